/* How METIS gives up without a signal.
 *
 * GKlib turns its errors into raise(SIGABRT) and raise(SIGTERM) and catches them with handlers that jump to a buffer of
 * the thread that is in METIS. Handlers belong to the process: while one thread was in METIS, a SIGTERM from outside
 * arrived in another and jumped to a buffer that nobody had filled. Here are all symbols that METIS takes from GKlib's
 * error.c, so that the linker leaves that file out: the same jump, without handlers. A symbol that a later METIS takes
 * beside these is defined twice, which the linker says.
 */

#include <setjmp.h>
#include <signal.h>

/* As many as in GKlib; calls of METIS do not nest, so that one would do. */
#define MOST_BUFFERS 128

/* gk_sigcatch() of GKlib is setjmp(gk_jbufs[gk_cur_jbufs]). */
__thread int gk_cur_jbufs = -1;
__thread jmp_buf gk_jbufs[MOST_BUFFERS];

int gk_sigtrap(void)
{
  if (gk_cur_jbufs + 1 >= MOST_BUFFERS)
    return 0;
  gk_cur_jbufs++;
  return 1;
}

int gk_siguntrap(void)
{
  if (gk_cur_jbufs < 0)
    return 0;
  gk_cur_jbufs--;
  return 1;
}

/* SIGABRT says that memory ran out, SIGTERM anything else; METIS returns it as its status. */
void gk_errexit(int reason, char *format, ...)
{
  (void)format;
  if (gk_cur_jbufs >= 0)
    longjmp(gk_jbufs[gk_cur_jbufs], reason);
}

void errexit(char *format, ...)
{
  gk_errexit(SIGTERM, format);
}

/* The linker takes this file where somebody asks for it. */
void fracas_metis_errors(void)
{
}
