/* What both files of the interface share. */
#ifndef FRACAS_SHARED_H
#define FRACAS_SHARED_H
#include <petscksp.h>

/* Rust hands int and double over. */
#if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE) || defined(PETSC_USE_64BIT_INDICES)
#error "fracas needs a PETSc with real scalars of 64 bits and indices of 32 bits"
#endif

/* What a handle is made of. */
typedef struct {
  Mat a;
  PC pc;
  Vec r, z;
  double flops;
} fracas_petsc;

/* The sentence of an error until it is told. */
extern char fracas_said[1024];
#define said fracas_said

/* Tells it and returns the code. */
int fracas_told(int code, char *text, int length);

/* Ranks of mpirun work together, and have not taken leave of each other. */
extern int fracas_together;

/* 0, or why a kind of preconditioner with these options cannot be set up on a matrix. */
int fracas_set_up(fracas_petsc *h, MPI_Comm comm, int kind, const char *options);

/* Near null space of a matrix with three rows a node: n entries x, y, z of every node here. */
int fracas_rigid_modes(fracas_petsc *h, MPI_Comm comm, int n, const double *positions);

/* A vector of n entries here without memory of its own. */
int fracas_vector(MPI_Comm comm, int block, int n, const double *entries, Vec *out);

void fracas_petsc_free(fracas_petsc *h);

#endif
