/* PETSc's preconditioners behind a flat interface. Whoever calls holds a lock: PETSc serves one thread at a time. */
#include "shared.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GAMG = 0, BOOMERAMG = 1, MUMPS_SPD = 2, MUMPS_SYMMETRIC = 3, MUMPS_LU = 4 };

/* Beyond PETSc's own codes. */
enum { REFUSED_OPTION = -1, FAILED_SETUP = -2 };

char fracas_said[1024];
int fracas_together = 0;

/* Exit status of ranks that one of them leaves behind. */
enum { LEFT = 2 };

/* Keeps the first sentence of an error and returns its code to the caller. */
static PetscErrorCode keep(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode n, PetscErrorType type,
                           const char *message, void *context)
{
  const char *general = NULL;
  (void)comm;
  (void)line;
  (void)file;
  (void)context;
  if (type != PETSC_ERROR_INITIAL || said[0]) return n;
  PetscErrorMessage(n, &general, NULL);
  snprintf(said, sizeof said, "%s in %s: %s", general ? general : "error", function ? function : "PETSc", message ? message : "");
  for (char *c = said; *c; c++)
    if (*c == '\n' || *c == '\r') *c = ' ';
  return n;
}

int fracas_told(int code, char *text, int length)
{
  if (text && length > 0) snprintf(text, (size_t)length, "%s", said);
  said[0] = 0;
  return code;
}

/* MPI keeps a folder until it ends. A rank that goes before all take leave ends the others, which would wait for it. */
static void end(void)
{
  int ended = 0;
  MPI_Finalized(&ended);
  if (ended) return;
  if (fracas_together) MPI_Abort(MPI_COMM_WORLD, LEFT);
  MPI_Finalize();
}

int fracas_petsc_start(int together, char *text, int length)
{
  int begun = 0, provided = 0;
  said[0] = 0;
  MPI_Initialized(&begun);
  if (!begun && MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS) {
    snprintf(said, sizeof said, "MPI does not start");
    return fracas_told(1, text, length);
  }
  if (!begun) atexit(end);
  MPI_Query_thread(&provided);
  if (provided < MPI_THREAD_SERIALIZED) {
    snprintf(said, sizeof said, "MPI serves one thread alone (MPI_THREAD_SERIALIZED is needed)");
    return fracas_told(1, text, length);
  }
  fracas_together = together;
  PETSC_COMM_WORLD = together ? MPI_COMM_WORLD : MPI_COMM_SELF;
  int code = PetscOptionsSetValue(NULL, "-no_signal_handler", "true");
  if (!code) code = PetscOptionsSetValue(NULL, "-skip_petscrc", "true");
  if (!code) code = PetscInitializeNoArguments();
  if (!code) code = PetscPushErrorHandler(keep, NULL);
  /* what PETSC_OPTIONS says is no part of a scene */
  if (!code) code = PetscOptionsClear(NULL);
  return fracas_told(code, text, length);
}

static int option_left(void)
{
  PetscInt left = 0;
  char **names = NULL, **values = NULL;
  int code = PetscOptionsLeftGet(NULL, &left, &names, &values);
  if (code) return code;
  if (left > 0) {
    snprintf(said, sizeof said, "-%s", names[0]);
    code = REFUSED_OPTION;
  }
  PetscOptionsLeftRestore(NULL, &left, &names, &values);
  return code;
}

static int one_is_fixed(void)
{
  static const char *const fixed[] = {"-pc_type", "-pc_hypre_type", "-pc_factor_mat_solver_type"};
  for (size_t k = 0; k < sizeof fixed / sizeof *fixed; k++) {
    PetscBool has = PETSC_FALSE;
    int code = PetscOptionsHasName(NULL, NULL, fixed[k], &has);
    if (code) return code;
    if (has) {
      snprintf(said, sizeof said, "%s", fixed[k]);
      return REFUSED_OPTION;
    }
  }
  return 0;
}

int fracas_vector(MPI_Comm comm, int block, int n, const double *entries, Vec *out)
{
  if (comm == MPI_COMM_SELF) return VecCreateSeqWithArray(comm, block, n, entries, out);
  return VecCreateMPIWithArray(comm, block, n, PETSC_DETERMINE, entries, out);
}

int fracas_rigid_modes(fracas_petsc *h, MPI_Comm comm, int n, const double *positions)
{
  Vec coordinates;
  MatNullSpace modes;
  PetscCall(fracas_vector(comm, 3, n, positions, &coordinates));
  PetscCall(MatNullSpaceCreateRigidBody(coordinates, &modes));
  PetscCall(MatSetNearNullSpace(h->a, modes));
  PetscCall(MatNullSpaceDestroy(&modes));
  return VecDestroy(&coordinates);
}

static int direct(fracas_petsc *h, int kind)
{
  Mat factors;
  if (kind == MUMPS_SPD) PetscCall(MatSetOption(h->a, MAT_SPD, PETSC_TRUE));
  if (kind == MUMPS_SYMMETRIC) PetscCall(MatSetOption(h->a, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(PCSetType(h->pc, kind == MUMPS_LU ? PCLU : PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(h->pc, MATSOLVERMUMPS));
  PetscCall(PCFactorSetUpMatSolverType(h->pc));
  PetscCall(PCFactorGetMatrix(h->pc, &factors));
  /* twice the memory that the analysis foresees: pivots move */
  return MatMumpsSetIcntl(factors, 14, 100);
}

static int multigrid(fracas_petsc *h, int kind)
{
  PetscCall(MatSetOption(h->a, MAT_SPD, PETSC_TRUE));
  PetscCall(PCSetType(h->pc, kind == GAMG ? PCGAMG : PCHYPRE));
  return kind == BOOMERAMG ? PCHYPRESetType(h->pc, "boomeramg") : 0;
}

/* Flops that PETSc counts in one application; what it calls outside itself does not count. */
static int count(fracas_petsc *h)
{
  PetscLogDouble before, after;
  PetscCall(VecSet(h->r, 1.0));
  PetscCall(PetscGetFlops(&before));
  PetscCall(PCApply(h->pc, h->r, h->z));
  PetscCall(PetscGetFlops(&after));
  h->flops = after - before;
  return 0;
}

static int failed(fracas_petsc *h, int kind)
{
  PCFailedReason reason;
  PetscCall(PCGetFailedReason(h->pc, &reason));
  if (reason == PC_NOERROR) return 0;
  if (kind >= MUMPS_SPD) {
    Mat factors;
    PetscInt one = 0, two = 0;
    PetscCall(PCFactorGetMatrix(h->pc, &factors));
    PetscCall(MatMumpsGetInfog(factors, 1, &one));
    PetscCall(MatMumpsGetInfog(factors, 2, &two));
    snprintf(said, sizeof said, "INFOG(1) = %d, INFOG(2) = %d", (int)one, (int)two);
    return one ? (int)one - 1000 : FAILED_SETUP;
  }
  snprintf(said, sizeof said, "set-up failed with reason %d", (int)reason);
  return FAILED_SETUP;
}

/* Products of coarse levels add what other ranks send in the order of ranks; PETSc's own choice adds it as it comes, other bits every run. */
static int in_order(void)
{
  PetscBool has = PETSC_FALSE;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-matptap_via", &has));
  if (!has) PetscCall(PetscOptionsSetValue(NULL, "-matptap_via", "allatonce"));
  /* asked for, it counts as read where there is one level alone */
  return PetscOptionsHasName(NULL, NULL, "-matptap_via", &has);
}

int fracas_set_up(fracas_petsc *h, MPI_Comm comm, int kind, const char *options)
{
  PetscCall(PCCreate(comm, &h->pc));
  PetscCall(PCSetOperators(h->pc, h->a, h->a));
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertString(NULL, options));
  if (comm != MPI_COMM_SELF) PetscCall(in_order());
  int code = one_is_fixed();
  if (code) return code;
  PetscCall(kind >= MUMPS_SPD ? direct(h, kind) : multigrid(h, kind));
  PetscCall(PCSetFromOptions(h->pc));
  PetscCall(PCSetUp(h->pc));
  code = option_left();
  return code ? code : failed(h, kind);
}

static int make(fracas_petsc *h, int kind, int n, int block, const int *offsets, const int *columns, const double *values,
                const double *positions, const char *options)
{
  PetscCall(MatCreate(PETSC_COMM_SELF, &h->a));
  PetscCall(MatSetSizes(h->a, n, n, n, n));
  PetscCall(MatSetType(h->a, MATSEQAIJ));
  PetscCall(MatSetBlockSize(h->a, block));
  PetscCall(MatSeqAIJSetPreallocationCSR(h->a, offsets, columns, values));
  if (positions) PetscCall(fracas_rigid_modes(h, PETSC_COMM_SELF, n, positions));
  PetscCall(fracas_vector(PETSC_COMM_SELF, block, n, NULL, &h->r));
  PetscCall(fracas_vector(PETSC_COMM_SELF, block, n, NULL, &h->z));
  return fracas_set_up(h, PETSC_COMM_SELF, kind, options);
}

void fracas_petsc_free(fracas_petsc *h)
{
  if (!h) return;
  PCDestroy(&h->pc);
  VecDestroy(&h->r);
  VecDestroy(&h->z);
  MatDestroy(&h->a);
  free(h);
  said[0] = 0;
}

int fracas_petsc_new(int kind, int n, int block, const int *offsets, const int *columns, const double *values,
                     const double *positions, const char *options, fracas_petsc **out, char *text, int length)
{
  fracas_petsc *h = calloc(1, sizeof *h);
  *out = NULL;
  said[0] = 0;
  if (!h) return PETSC_ERR_MEM;
  int code = make(h, kind, n, block, offsets, columns, values, positions, options);
  if (code) {
    fracas_told(code, text, length);
    PetscOptionsClear(NULL);
    fracas_petsc_free(h);
    return code;
  }
  PetscOptionsClear(NULL);
  *out = h;
  return 0;
}

static int apply(fracas_petsc *h, int transposed, const double *r, double *z)
{
  PetscCall(VecPlaceArray(h->r, r));
  PetscCall(VecPlaceArray(h->z, z));
  int code = transposed ? PCApplyTranspose(h->pc, h->r, h->z) : PCApply(h->pc, h->r, h->z);
  VecResetArray(h->r);
  VecResetArray(h->z);
  return code;
}

int fracas_petsc_apply(fracas_petsc *h, int transposed, const double *r, double *z, char *text, int length)
{
  said[0] = 0;
  return fracas_told(apply(h, transposed, r, z), text, length);
}

int fracas_petsc_count(fracas_petsc *h, double *r, double *z, double *flops)
{
  VecPlaceArray(h->r, r);
  VecPlaceArray(h->z, z);
  int code = count(h);
  VecResetArray(h->r);
  VecResetArray(h->z);
  *flops = h->flops;
  said[0] = 0;
  return code;
}

int fracas_petsc_mumps(fracas_petsc *h, int index, double *value)
{
  Mat factors;
  PetscInt info = 0;
  int code = PCFactorGetMatrix(h->pc, &factors);
  if (!code) code = MatMumpsGetInfog(factors, index, &info);
  /* MUMPS writes what is beyond 32 bits as minus its millions */
  *value = info < 0 ? -1e6 * (double)info : (double)info;
  said[0] = 0;
  return code;
}
