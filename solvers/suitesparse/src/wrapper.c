/* A flat interface to CHOLMOD (supernodal LL') and UMFPACK (LU): 64-bit indices, orderings given by the caller.
   Every function returns 0 or a status of the library; a handle is used by one thread at a time, except in the
   functions named *_solve, which change nothing in it. */

#include "cholmod.h"
#include "umfpack.h"

typedef struct
{
    cholmod_common common ;
    cholmod_factor *factor ;
} fracas_cholmod ;

static cholmod_sparse symmetric (int64_t n, int64_t *p, int64_t *i, double *x)
{
    /* the lower triangle counts, the upper one is ignored */
    cholmod_sparse a = { .nrow = n, .ncol = n, .nzmax = p [n], .p = p, .i = i, .x = x, .stype = -1,
        .itype = CHOLMOD_LONG, .xtype = x ? CHOLMOD_REAL : CHOLMOD_PATTERN, .dtype = CHOLMOD_DOUBLE,
        .sorted = 1, .packed = 1 } ;
    return a ;
}

void fracas_cholmod_free (fracas_cholmod *h)
{
    if (h == NULL) return ;
    cholmod_l_free_factor (&h->factor, &h->common) ;
    cholmod_l_finish (&h->common) ;
    free (h) ;
}

static fracas_cholmod *start (void)
{
    fracas_cholmod *h = calloc (1, sizeof (fracas_cholmod)) ;
    if (h == NULL) return NULL ;
    cholmod_l_start (&h->common) ;
    h->common.print = 0 ;
    h->common.supernodal = CHOLMOD_SUPERNODAL ;
    h->common.nmethods = 1 ;
    h->common.method [0].ordering = CHOLMOD_GIVEN ;
    h->common.postorder = 1 ;
    return h ;
}

int fracas_cholmod_analyze (int64_t n, int64_t *p, int64_t *i, int64_t *order, fracas_cholmod **out)
{
    cholmod_sparse a = symmetric (n, p, i, NULL) ;
    fracas_cholmod *h = *out = start () ;
    if (h == NULL) return CHOLMOD_OUT_OF_MEMORY ;
    h->factor = cholmod_l_analyze_p (&a, order, NULL, 0, &h->common) ;
    return h->factor ? 0 : h->common.status ;
}

int fracas_cholmod_factorize (const fracas_cholmod *symbolic, int64_t n, int64_t *p, int64_t *i, double *x,
    fracas_cholmod **out, int64_t *minor)
{
    cholmod_sparse a = symmetric (n, p, i, x) ;
    fracas_cholmod *h = *out = start () ;
    if (h == NULL) return CHOLMOD_OUT_OF_MEMORY ;
    h->factor = cholmod_l_copy_factor (symbolic->factor, &h->common) ;
    if (h->factor == NULL) return h->common.status ;
    cholmod_l_factorize (&a, h->factor, &h->common) ;
    *minor = h->factor->minor ;
    return h->common.status ;
}

/* sizes: entries of the factor, workspace entries per right-hand side */
void fracas_cholmod_sizes (const fracas_cholmod *h, int64_t *entries, int64_t *work)
{
    *entries = h->factor->xsize ;
    *work = h->factor->maxesize ;
}

/* order of elimination after postordering; order [k] is the k-th pivot's row */
void fracas_cholmod_order (const fracas_cholmod *h, int64_t *order)
{
    memcpy (order, h->factor->Perm, h->factor->n * sizeof (int64_t)) ;
}

/* diagonal of L, in the order of elimination */
void fracas_cholmod_diagonal (const fracas_cholmod *h, double *diagonal)
{
    const cholmod_factor *l = h->factor ;
    const int64_t *super = l->super, *pi = l->pi, *px = l->px ;
    const double *x = l->x ;
    for (size_t s = 0 ; s < l->nsuper ; s++)
    {
        int64_t rows = pi [s+1] - pi [s] ;
        for (int64_t j = super [s] ; j < super [s+1] ; j++)
            diagonal [j] = x [px [s] + (j - super [s]) * (rows + 1)] ;
    }
}

/* x <- L'\(L\x) for permuted columns x; work holds maxesize entries per column */
int fracas_cholmod_solve (const fracas_cholmod *h, int64_t columns, double *x, double *work)
{
    cholmod_common common = h->common ;
    cholmod_factor *l = h->factor ;
    cholmod_dense b = { .nrow = l->n, .ncol = columns, .nzmax = l->n * columns, .d = l->n, .x = x,
        .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE } ;
    cholmod_dense e = { .nrow = columns, .ncol = l->maxesize, .nzmax = columns * l->maxesize, .d = columns,
        .x = work, .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE } ;
    int ok = cholmod_l_super_lsolve (l, &b, &e, &common) && cholmod_l_super_ltsolve (l, &b, &e, &common) ;
    return ok ? 0 : common.status ? common.status : CHOLMOD_INVALID ;
}

static void umfpack_settings (double control [UMFPACK_CONTROL])
{
    umfpack_dl_defaults (control) ;
    control [UMFPACK_SCALE] = UMFPACK_SCALE_NONE ; /* the caller equilibrates */
    control [UMFPACK_IRSTEP] = 0 ;                 /* the caller refines */
}

/* symmetric: prefer the diagonal and keep the order; otherwise the order of columns may be refined */
int fracas_umfpack_analyze (int symmetric, int64_t n, const int64_t *p, const int64_t *i, const int64_t *order,
    void **symbolic)
{
    double control [UMFPACK_CONTROL] ;
    umfpack_settings (control) ;
    control [UMFPACK_STRATEGY] = symmetric ? UMFPACK_STRATEGY_SYMMETRIC : UMFPACK_STRATEGY_UNSYMMETRIC ;
    return umfpack_dl_qsymbolic (n, n, p, i, NULL, order, symbolic, control, NULL) ;
}

int fracas_umfpack_factorize (const int64_t *p, const int64_t *i, const double *x, void *symbolic, void **numeric,
    int64_t *entries)
{
    double control [UMFPACK_CONTROL], info [UMFPACK_INFO] ;
    umfpack_settings (control) ;
    int status = umfpack_dl_numeric (p, i, x, symbolic, numeric, control, info) ;
    *entries = info [UMFPACK_LNZ] + info [UMFPACK_UNZ] ;
    if (status == UMFPACK_ERROR_out_of_memory)
        *entries = info [UMFPACK_NUMERIC_SIZE_ESTIMATE] * info [UMFPACK_SIZE_OF_UNIT] / sizeof (double) ;
    return status ;
}

/* z <- A\r, or A'\r; wi and w hold n entries each */
int fracas_umfpack_solve (int transposed, const int64_t *p, const int64_t *i, const double *x, double *z,
    const double *r, void *numeric, int64_t *wi, double *w)
{
    double control [UMFPACK_CONTROL] ;
    umfpack_settings (control) ;
    return umfpack_dl_wsolve (transposed ? UMFPACK_At : UMFPACK_A, p, i, x, z, r, numeric, control, NULL, wi, w) ;
}

/* det A = mantissa 10^exponent */
int fracas_umfpack_determinant (double *mantissa, double *exponent, void *numeric)
{
    return umfpack_dl_get_determinant (mantissa, exponent, numeric, NULL) ;
}

void fracas_umfpack_free_symbolic (void **symbolic) { umfpack_dl_free_symbolic (symbolic) ; }
void fracas_umfpack_free_numeric (void **numeric) { umfpack_dl_free_numeric (numeric) ; }
