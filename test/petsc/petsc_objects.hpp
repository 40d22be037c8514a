// PETSc in tests: objects that end with their scope, calls whose errors are exceptions, matrices from lists.
#pragma once

#include <petscksp.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "test/reference/sparse.hpp"

namespace mfs::test {

using Sparse = BasicSparseMatrix<PetscScalar>;

/// `get` is PetscErrorMessage, whose text is const in newer versions.
template <class Text>
std::string error_text_by(PetscErrorCode (*get)(PetscErrorCode, const char*[], Text**)) {
  Text* text = nullptr;
  get(PETSC_ERR_LIB, nullptr, &text);
  return text != nullptr ? text : "";
}
/// What PETSc said of its last error.
inline std::string error_text() {
  return error_text_by(PetscErrorMessage);
}

/// Throws where PETSc reports an error.
inline void good(PetscErrorCode code) {
  if (code != 0)
    throw std::runtime_error("PETSc error " + std::to_string(static_cast<int>(code)) + ": " + error_text());
}

template <class Object, PetscErrorCode (*destroy)(Object*)>
class Held {
 public:
  Held() = default;
  ~Held() { destroy(&object_); }
  Held(Held&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Held& operator=(Held&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  operator Object() const { return object_; }  // NOLINT: implicit by intent
  Object* place() { return &object_; }

 private:
  Object object_ = nullptr;
};
using Matrix = Held<Mat, MatDestroy>;
using Vector = Held<Vec, VecDestroy>;
using Krylov = Held<KSP, KSPDestroy>;

/// An option of the database, as long as it lives.
class Option {
 public:
  Option(std::string name, const std::string& value) : name_(std::move(name)) {
    good(PetscOptionsSetValue(nullptr, name_.c_str(), value.c_str()));
  }
  ~Option() { PetscOptionsClearValue(nullptr, name_.c_str()); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  std::string name_;
};

inline void set_values(Mat m, const Sparse& a) {
  for (std::int64_t i = 0; i < a.n; ++i)
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      good(MatSetValue(m, static_cast<PetscInt>(i), a.columns[k], a.values[k], INSERT_VALUES));
  good(MatAssemblyBegin(m, MAT_FINAL_ASSEMBLY));
  good(MatAssemblyEnd(m, MAT_FINAL_ASSEMBLY));
}

/// A MATSEQAIJ; entries of one place must have been summed.
inline Matrix petsc_matrix(const Sparse& a) {
  std::vector<PetscInt> lengths;
  for (std::int64_t i = 0; i < a.n; ++i)
    lengths.push_back(static_cast<PetscInt>(a.offsets[i + 1] - a.offsets[i]));
  Matrix m;
  const auto n = static_cast<PetscInt>(a.n);
  good(MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 0, lengths.data(), m.place()));
  set_values(m, a);
  return m;
}

inline Vector petsc_vector(const std::vector<PetscScalar>& values) {
  Vector v;
  PetscScalar* array = nullptr;
  good(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(values.size()), v.place()));
  good(VecGetArray(v, &array));
  std::copy(values.begin(), values.end(), array);
  good(VecRestoreArray(v, &array));
  return v;
}

inline std::vector<PetscScalar> entries_of(Vec v) {
  PetscInt n = 0;
  const PetscScalar* array = nullptr;
  good(VecGetLocalSize(v, &n));
  good(VecGetArrayRead(v, &array));
  std::vector<PetscScalar> values(array, array + n);
  good(VecRestoreArrayRead(v, &array));
  return values;
}

/// What `show` writes into an ASCII viewer.
template <class Show>
std::string text_of(MPI_Comm comm, const Show& show) {
  char* text = nullptr;
  std::size_t length = 0;
  std::FILE* stream = open_memstream(&text, &length);
  PetscViewer viewer = nullptr;
  good(PetscViewerASCIIOpenWithFILE(comm, stream, &viewer));
  good(PetscViewerPushFormat(viewer, PETSC_VIEWER_ASCII_INFO));
  good(show(viewer));
  good(PetscViewerDestroy(&viewer));
  std::fclose(stream);
  std::string result(text, length);
  std::free(text);
  return result;
}

}  // namespace mfs::test
