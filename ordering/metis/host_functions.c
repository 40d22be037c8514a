/* What METIS gets in place of the C library's rand, malloc, printf, signal, raise, exit and abort (CMakeLists.txt
 * renames them while METIS is compiled).
 *
 * Random numbers: one state per thread, seeded by METIS at each call, so that a result depends on the graph
 * and the seed alone and the caller's rand() is left alone.
 *
 * Errors: METIS raises a signal, and its entry points set a handler that jumps back into them. Handlers
 * belong to the whole process; here raise jumps by itself to where the thread's entry point waits, and signal
 * does nothing. Memory taken by the failed call is given back by METIS' own bookkeeping (gk_malloc_cleanup).
 *
 * Memory: METIS goes over the arrays of a graph in random order, so the largest are asked for in huge pages.
 */
#include <GKlib.h>
#include <metis.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

/* xorshift64* (Vigna, "An experimental exploration of Marsaglia's xorshift generators", ACM TOMS 42, 2016).
 */
static __thread uint64_t random_state = 1;

void mfs_metis_srand(unsigned int seed) {
  random_state = (uint64_t)seed * 0x9E3779B97F4A7C15u + 1u; /* never 0 for a 32-bit seed */
}

int mfs_metis_rand(void) {
  random_state ^= random_state >> 12;
  random_state ^= random_state << 25;
  random_state ^= random_state >> 27;
  return (int)((random_state * 0x2545F4914F6CDD1Du) >> 33); /* 0 ... RAND_MAX = 2^31 - 1 */
}

void* mfs_metis_malloc(size_t bytes) {
  const size_t page = (size_t)2 << 20;
  if (bytes < 2 * page) return malloc(bytes);
  if (bytes > SIZE_MAX - page) return NULL;
  const size_t pages = (bytes + page - 1) / page * page;
  void* data = aligned_alloc(page, pages);
  if (data != NULL) madvise(data, pages, MADV_HUGEPAGE); /* refusal is no error */
  return data;
}

int mfs_metis_printf(const char* format, ...) {
  (void)format;
  return 0;
}

int mfs_metis_fprintf(FILE* stream, const char* format, ...) {
  (void)stream;
  (void)format;
  return 0;
}

int mfs_metis_vfprintf(FILE* stream, const char* format, va_list arguments) {
  (void)stream;
  (void)format;
  (void)arguments;
  return 0;
}

void (*mfs_metis_signal(int number, void (*handler)(int)))(int) {
  (void)number;
  (void)handler;
  return SIG_DFL;
}

int mfs_metis_raise(int number) {
  if (gk_cur_jbufs < 0) __builtin_trap(); /* every entry point of METIS sets a return point first */
  longjmp(gk_jbufs[gk_cur_jbufs], number);
}

void mfs_metis_exit(int status) {
  (void)status;
  mfs_metis_raise(SIGERR);
  __builtin_unreachable();
}

void mfs_metis_abort(void) {
  mfs_metis_raise(SIGERR);
  __builtin_unreachable();
}
