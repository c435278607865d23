/* Ranks of mpirun that hold parts of one system: sums, messages, ghosts, a matrix by rows. Every call but the one that frees a handle is
   made by all ranks. */
#include "shared.h"
#include <petscsf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Our own messages, apart from PETSc's. */
static MPI_Comm ranks = MPI_COMM_NULL;

/* Not a code of MPI: PETSc has begun for this process alone, or ranks have taken leave. */
enum { ALONE = -1 };

int fracas_ranks_begin(int *rank, int *size, int *beside)
{
  MPI_Comm machine;
  if (!fracas_together) return ALONE;
  int code = MPI_Comm_dup(MPI_COMM_WORLD, &ranks);
  if (!code) code = MPI_Comm_rank(ranks, rank);
  if (!code) code = MPI_Comm_size(ranks, size);
  if (!code) code = MPI_Comm_split_type(ranks, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  if (!code) code = MPI_Comm_size(machine, beside);
  if (!code) code = MPI_Comm_free(&machine);
  return code;
}

void fracas_ranks_leave(void)
{
  MPI_Barrier(ranks);
  fracas_together = 0;
}

void fracas_ranks_abort(int status)
{
  MPI_Abort(MPI_COMM_WORLD, status);
}

/* Recursive doubling in an order of its own: the same bits on every rank, and in every run with as many ranks. */
void fracas_ranks_sum(double *sums, double *other, int n)
{
  int rank, size, whole = 1;
  MPI_Comm_rank(ranks, &rank);
  MPI_Comm_size(ranks, &size);
  while (2 * whole <= size) whole *= 2;
  if (rank >= whole) {
    MPI_Send(sums, n, MPI_DOUBLE, rank - whole, 1, ranks);
    MPI_Recv(sums, n, MPI_DOUBLE, rank - whole, 2, ranks, MPI_STATUS_IGNORE);
    return;
  }
  if (rank + whole < size) {
    MPI_Recv(other, n, MPI_DOUBLE, rank + whole, 1, ranks, MPI_STATUS_IGNORE);
    for (int k = 0; k < n; k++) sums[k] += other[k];
  }
  for (int step = 1; step < whole; step *= 2) {
    MPI_Sendrecv(sums, n, MPI_DOUBLE, rank ^ step, 3, other, n, MPI_DOUBLE, rank ^ step, 3, ranks, MPI_STATUS_IGNORE);
    /* a + b is b + a */
    for (int k = 0; k < n; k++) sums[k] += other[k];
  }
  if (rank + whole < size) MPI_Send(sums, n, MPI_DOUBLE, rank + whole, 2, ranks);
}

void fracas_ranks_gather(const double *own, int n, double *all)
{
  MPI_Allgather(own, n, MPI_DOUBLE, all, n, MPI_DOUBLE, ranks);
}

void fracas_ranks_collect(const double *own, int n, double *all, const int *lengths, const int *firsts)
{
  MPI_Gatherv(own, n, MPI_DOUBLE, all, lengths, firsts, MPI_DOUBLE, 0, ranks);
}

void fracas_ranks_tell(int from, void *bytes, int n)
{
  MPI_Bcast(bytes, n, MPI_BYTE, from, ranks);
}

int fracas_ranks_failed(int failed, double patience, int *all)
{
  MPI_Request request;
  int done = 0;
  double start = MPI_Wtime();
  MPI_Iallgather(&failed, 1, MPI_INT, all, 1, MPI_INT, ranks, &request);
  /* whoever failed may be alone: the others wait for it elsewhere */
  while (failed && !done) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (!done && MPI_Wtime() - start > patience) return 1;
  }
  if (!done) MPI_Wait(&request, MPI_STATUS_IGNORE);
  return 0;
}

int fracas_ghosts_new(int own, int ghosts, const int *owners, const int *places, PetscSF *out, char *text, int length)
{
  PetscSFNode *remote = NULL;
  *out = NULL;
  said[0] = 0;
  int code = PetscMalloc1(ghosts, &remote);
  for (int k = 0; !code && k < ghosts; k++) {
    remote[k].rank = owners[k];
    remote[k].index = places[k];
  }
  if (!code) code = PetscSFCreate(ranks, out);
  if (!*out) {
    PetscFree(remote);
    return fracas_told(code, text, length);
  }
  /* the forest has the list from here on */
  if (!code) code = PetscSFSetGraph(*out, own, ghosts, NULL, PETSC_COPY_VALUES, remote, PETSC_OWN_POINTER);
  if (!code) code = PetscSFSetUp(*out);
  if (code) PetscSFDestroy(out);
  return fracas_told(code, text, length);
}

int fracas_ghosts_fill(PetscSF ghosts, const double *own, double *filled)
{
  int code = PetscSFBcastBegin(ghosts, MPIU_SCALAR, own, filled, MPI_REPLACE);
  if (!code) code = PetscSFBcastEnd(ghosts, MPIU_SCALAR, own, filled, MPI_REPLACE);
  said[0] = 0;
  return code;
}

void fracas_ghosts_free(PetscSF ghosts)
{
  PetscSFDestroy(&ghosts);
  said[0] = 0;
}

static int rows(fracas_petsc *h, int n, const int *offsets, const int *columns, const double *values, const double *positions)
{
  PetscCall(MatCreate(PETSC_COMM_WORLD, &h->a));
  PetscCall(MatSetSizes(h->a, n, n, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(h->a, MATMPIAIJ));
  PetscCall(MatSetBlockSize(h->a, 3));
  PetscCall(MatMPIAIJSetPreallocationCSR(h->a, offsets, columns, values));
  if (positions) PetscCall(fracas_rigid_modes(h, PETSC_COMM_WORLD, n, positions));
  PetscCall(fracas_vector(PETSC_COMM_WORLD, 3, n, NULL, &h->r));
  return fracas_vector(PETSC_COMM_WORLD, 3, n, NULL, &h->z);
}

int fracas_ranks_matrix(int n, const int *offsets, const int *columns, const double *values, const double *positions,
                        fracas_petsc **out, char *text, int length)
{
  fracas_petsc *h = calloc(1, sizeof *h);
  *out = NULL;
  said[0] = 0;
  if (!h) return PETSC_ERR_MEM;
  int code = rows(h, n, offsets, columns, values, positions);
  if (code) {
    fracas_told(code, text, length);
    fracas_petsc_free(h);
    return code;
  }
  *out = h;
  return 0;
}

int fracas_ranks_set_up(fracas_petsc *h, int kind, const char *options, char *text, int length)
{
  said[0] = 0;
  int code = fracas_set_up(h, PETSC_COMM_WORLD, kind, options);
  fracas_told(code, text, length);
  PetscOptionsClear(NULL);
  return code;
}

/* Half the time of a message and its answer between ranks 0 and 1, of n numbers, as often as asked; 0 where there is one rank. */
double fracas_ranks_ping(double *numbers, int n, int times)
{
  int rank, size;
  MPI_Comm_rank(ranks, &rank);
  MPI_Comm_size(ranks, &size);
  MPI_Barrier(ranks);
  double start = MPI_Wtime();
  for (int k = 0; size > 1 && k < times && rank < 2; k++) {
    if (rank == 0) {
      MPI_Send(numbers, n, MPI_DOUBLE, 1, 4, ranks);
      MPI_Recv(numbers, n, MPI_DOUBLE, 1, 4, ranks, MPI_STATUS_IGNORE);
    } else {
      MPI_Recv(numbers, n, MPI_DOUBLE, 0, 4, ranks, MPI_STATUS_IGNORE);
      MPI_Send(numbers, n, MPI_DOUBLE, 0, 4, ranks);
    }
  }
  return size > 1 ? (MPI_Wtime() - start) / (2.0 * times) : 0.0;
}
