/* MFS for C, and for all languages that call C (Fortran: mfs.f90). libmfs has these functions beside the C++
   class, which mfs/solver.hpp tells all about: each function here is the one of the same name there.

     mfs_solver* solver;
     mfs_create(MFS_DOUBLE, 32, &solver);                   numbers of double precision, 32-bit indices
     mfs_set_option(solver, "threads", "4");
     mfs_factor(solver, n, row_offsets, columns, values);   compressed rows, counted from 0
     mfs_solve(solver, b, x, 1, 0, 0);
     mfs_refactor(solver, values);                          new values on the same pattern
     mfs_destroy(solver);

   Every function that returns int returns MFS_OK, or the kind of error; mfs_last_error then has its text and
   its place. No exception comes out, nothing is printed, and the process is never ended. After an error a
   solver can be used as before.

   A matrix in compressed columns is the transposed one in compressed rows: pass its arrays, and solve with
   mfs_solve_transpose.

   One solver belongs to one thread at a time; solvers are independent of each other. A solver never frees an
   array of the caller, and holds none beyond the call. */
#ifndef MFS_MFS_H
#define MFS_MFS_H

#include <stdint.h>

#if defined(__GNUC__)
#define MFS_C_API __attribute__((visibility("default")))
#else
#define MFS_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The numbers of a solver. Complex ones are pairs of real and imaginary part, as C99's _Complex. */
enum { MFS_FLOAT = 0, MFS_DOUBLE = 1, MFS_COMPLEX_FLOAT = 2, MFS_COMPLEX_DOUBLE = 3 };

/* Statuses. Those from 3 to 7 are exit codes of the program mfs, too. */
enum {
  MFS_OK = 0,
  MFS_INVALID_INPUT = 3,        /* an argument or an option; the entry's row and column, where it is one */
  MFS_SINGULAR_MATRIX = 4,      /* the row and column that depend on the others */
  MFS_OUT_OF_MEMORY = 5,        /* of the host or of a device */
  MFS_ACCURACY_NOT_REACHED = 6, /* a solution missed the tolerance */
  MFS_BACKEND_ERROR = 7,        /* a library or device that MFS uses failed, or is not there */
  MFS_STATE_ERROR = 8,          /* calls out of order, as solve before factor */
  MFS_PATTERN_CHANGED = 9,      /* the first row that differs from the analysed pattern */
  MFS_INTERNAL_ERROR = 10       /* none of these */
};

typedef struct mfs_solver mfs_solver;

/* Makes a solver for numbers of kind `scalar` (above) and for indices of `index_bits` (32 or 64), or sets
 *solver to NULL. MFS_INVALID_INPUT, MFS_OUT_OF_MEMORY. */
MFS_C_API int mfs_create(int scalar, int index_bits, mfs_solver** solver);
/* Frees the solver; NULL is allowed. */
MFS_C_API void mfs_destroy(mfs_solver* solver);

/* Sets an option by its name and text; mfs_option_name lists the names, and mfs/options.hpp and
   mfs/analysis_options.hpp tell what they mean. MFS_INVALID_INPUT: no such option, a text that cannot be
   read, or a number that makes no sense; MFS_BACKEND_ERROR: a backend that is not there; MFS_STATE_ERROR:
   after the first mfs_analyze or mfs_factor. Options that do not go together are refused by these. */
MFS_C_API int mfs_set_option(mfs_solver* solver, const char* name, const char* value);
/* The name of option `index`, from 0; NULL from their number on. The text stays. */
MFS_C_API const char* mfs_option_name(int index);

/* Status, text and place (counted from 0; -1: none) of the last call of this thread that failed; MFS_OK and
   "" before that. The text stays until the next call that fails; of one that is longer than 1 023 bytes the
   end is left out. Each pointer may be NULL. */
MFS_C_API int mfs_last_error(const char** text, int64_t* row, int64_t* column);

/* The name of the argument or option that MFS_INVALID_INPUT is about ("values": NaN or infinity in the matrix;
   "b": in a right-hand side), if that was the last error of this thread; else "". */
MFS_C_API const char* mfs_last_error_argument(void);

/* Orders the pattern of an n x n matrix. `row_offsets` has n + 1 indices, `columns` row_offsets[n], and
   `values`, which may be NULL, as many numbers. What was analysed and factored before is forgotten.
   MFS_INVALID_INPUT, MFS_SINGULAR_MATRIX, MFS_OUT_OF_MEMORY, MFS_BACKEND_ERROR. */
MFS_C_API int mfs_analyze(mfs_solver* solver, int64_t n, const void* row_offsets, const void* columns,
                          const void* values);
/* Factors, and analyses first where nothing has been analysed. Later calls compare the pattern with the analysed
   one, and factor in the memory of the first. MFS_PATTERN_CHANGED, and what mfs_analyze
   returns. */
MFS_C_API int mfs_factor(mfs_solver* solver, int64_t n, const void* row_offsets, const void* columns,
                         const void* values);
/* Factors new values, which are in the order of the matrix last passed to mfs_analyze or mfs_factor.
   MFS_STATE_ERROR before the first mfs_factor, and what that returns. */
MFS_C_API int mfs_refactor(mfs_solver* solver, const void* values);

/* Solves A X = B, or A^T X = B (without conjugation), for n x columns numbers, column-major with leading
   dimensions ldb and ldx (0 means n). b and x may be the same array. MFS_STATE_ERROR, MFS_INVALID_INPUT,
   MFS_SINGULAR_MATRIX, MFS_ACCURACY_NOT_REACHED, MFS_OUT_OF_MEMORY, MFS_BACKEND_ERROR; x is then unchanged,
   but for whole blocks of 16 columns that were solved before. */
MFS_C_API int mfs_solve(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb,
                        int64_t ldx);
MFS_C_API int mfs_solve_transpose(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb,
                                  int64_t ldx);

/* The same for arrays in the memory of the device where the factors lie (option backend = cuda). After an
   mfs_analyze with values mfs_refactor_device may be the first factorization. `stream` is
   a cudaStream_t; NULL is the default stream. MFS_STATE_ERROR where the factors are not on a device. */
MFS_C_API int mfs_refactor_device(mfs_solver* solver, const void* values, void* stream);
MFS_C_API int mfs_solve_device(mfs_solver* solver, const void* b, void* x, int64_t columns, int64_t ldb,
                               int64_t ldx, void* stream);
MFS_C_API int mfs_solve_transpose_device(mfs_solver* solver, const void* b, void* x, int64_t columns,
                                         int64_t ldb, int64_t ldx, void* stream);

/* An estimate of |A|_1 |A^-1|_1, infinite where A is singular. MFS_STATE_ERROR, MFS_OUT_OF_MEMORY,
   MFS_ACCURACY_NOT_REACHED. */
MFS_C_API int mfs_condition_estimate(mfs_solver* solver, double* condition);
/* The determinant as phase * exp(log_abs): phase[0] and phase[1] are its real and imaginary part. Of a
   singular matrix both are 0, and log_abs is -infinity. Errors as above. */
MFS_C_API int mfs_determinant(mfs_solver* solver, double phase[2], double* log_abs);

/* A figure of the last analysis, factorization and solve, by name (mfs_report_name); 0 before these. What
   they are tells mfs/report.hpp. MFS_INVALID_INPUT: no such figure. */
MFS_C_API int mfs_report(const mfs_solver* solver, const char* name, double* value);
/* The name of figure `index`, from 0; NULL from their number on. The text stays. */
MFS_C_API const char* mfs_report_name(int index);

/* The version of the library that is loaded. */
MFS_C_API const char* mfs_version(void);
/* As mfs::set_default_threads (mfs/threads.hpp): of all solvers made from now on without the option threads.
   MFS_INVALID_INPUT. */
MFS_C_API int mfs_set_default_threads(int threads);

#ifdef __cplusplus
}
#endif

#endif
