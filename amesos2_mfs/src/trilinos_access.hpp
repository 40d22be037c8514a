// Plain arrays of Tpetra's and Epetra's matrices and vectors: the one place of the adapter that knows either.
//
//   MatrixAccess<Matrix>    Map, maps of rows / columns / unknowns, the local rows
//   VectorAccess<Vector>    Map, the local columns to read or to write
//   ids(map), same(a, b)    global ids of a map; whether two maps are equal (collective)
//
// Where kOnDevice is true, Tpetra's arrays lie in memory that a CUDA device reads (device_access.hpp): they
// are had in place by who works there, and copied for the host. Tpetra gives out no view of one side while
// one of the other side is held; so none is held longer than a phase lasts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include <Amesos2_config.h>
#include <Tpetra_CrsMatrix.hpp>
#include <Tpetra_MultiVector.hpp>
#ifdef HAVE_AMESOS2_EPETRA
#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_MultiVector.h>
#endif

#include "device_access.hpp"
#include "rooted_solver.hpp"

namespace mfs::amesos2 {

template <class Matrix>
struct MatrixAccess;
template <class Vector>
struct VectorAccess;

/// Keeps any value alive behind a pointer to nothing in particular.
template <class T>
std::shared_ptr<const void> keep(T value) {
  return std::make_shared<const T>(std::move(value));
}

// ---- Tpetra ----

template <class LO, class GO, class Node>
std::vector<std::int64_t> ids(const Teuchos::RCP<const Tpetra::Map<LO, GO, Node>>& map) {
  std::vector<std::int64_t> all(map->getMyGlobalIndices().extent(0));
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = map->getGlobalElement(static_cast<LO>(k));
  return all;
}

template <class LO, class GO, class Node>
bool same(const Teuchos::RCP<const Tpetra::Map<LO, GO, Node>>& a,
          const Teuchos::RCP<const Tpetra::Map<LO, GO, Node>>& b) {
  return a->isSameAs(*b);
}

template <class LO, class GO, class Node>
struct MatrixAccess<Tpetra::CrsMatrix<double, LO, GO, Node>> {
  static_assert(sizeof(LO) == sizeof(std::int32_t), "local ordinals have 32 bits");
  using Matrix = Tpetra::CrsMatrix<double, LO, GO, Node>;
  using Map = Teuchos::RCP<const Tpetra::Map<LO, GO, Node>>;

  static Map row_map(const Matrix& a) { return a.getRowMap(); }
  static Map column_map(const Matrix& a) { return a.getColMap(); }
  static Map unknown_map(const Matrix& a) { return a.getDomainMap(); }
  static bool complete(const Matrix& a) { return a.isFillComplete(); }

  /// In place, or copies where the host does not reach them.
  static LocalRows rows(const Matrix& a) {
    const auto local = a.getLocalMatrixDevice();
    const auto on_host = [](const auto& view) {
      return Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), view);
    };
    const auto held =
        std::make_tuple(on_host(local.graph.row_map), on_host(local.graph.entries), on_host(local.values));
    return {static_cast<std::int64_t>(local.numRows()), std::get<0>(held).data(), std::get<1>(held).data(),
            std::get<2>(held).data(), keep(held)};
  }

  static constexpr bool kOnDevice = reached_by_cuda<typename Node::memory_space>;
  /// libmfs works on the first device of the process.
  static bool on_first_device() { return typename Node::execution_space().cuda_device() == 0; }
  /// Where Tpetra's kernels run.
  static void* stream() { return typename Node::execution_space().cuda_stream(); }
  using DevicePattern = mfs::amesos2::DevicePattern<typename Matrix::local_graph_device_type>;
  static DevicePattern device_pattern(const Matrix& a) {
    return DevicePattern(a.getLocalMatrixDevice().graph);
  }
  /// The values where they lie, or nothing where the pattern is another.
  static DeviceValues device_values(const Matrix& a, const DevicePattern& pattern) {
    const auto local = a.getLocalMatrixDevice();
    if (!pattern.matches(local.graph)) return {};
    return {local.values.data(), stream(), keep(local.values)};
  }
};

template <class LO, class GO, class Node>
struct VectorAccess<Tpetra::MultiVector<double, LO, GO, Node>> {
  using Vector = Tpetra::MultiVector<double, LO, GO, Node>;
  using Map = Teuchos::RCP<const Tpetra::Map<LO, GO, Node>>;

  static Map map(const Vector& v) { return v.getMap(); }
  static std::int64_t length(const Vector& v) { return static_cast<std::int64_t>(v.getGlobalLength()); }
  static std::int64_t columns(const Vector& v) { return static_cast<std::int64_t>(v.getNumVectors()); }
  static bool supported(const Vector&) { return true; }

  /// Whether the columns of `v` lie at one distance from each other.
  static bool one_distance(const Vector& v) { return v.isConstantStride(); }
  /// These columns, on the device or on the host; nothing where they do not. `hold` keeps them in place.
  static LocalColumns<const double> read(const Vector& v, std::shared_ptr<const void>& hold, bool device) {
    if (!one_distance(v)) return {};
    return device ? columns_of(v.getLocalViewDevice(Tpetra::Access::ReadOnly), hold, device)
                  : columns_of(v.getLocalViewHost(Tpetra::Access::ReadOnly), hold, device);
  }
  static LocalColumns<double> write(Vector& v, std::shared_ptr<const void>& hold, bool device) {
    if (!one_distance(v)) return {};
    return device ? columns_of(v.getLocalViewDevice(Tpetra::Access::ReadWrite), hold, device)
                  : columns_of(v.getLocalViewHost(Tpetra::Access::ReadWrite), hold, device);
  }
  static void copy_from(const Vector& v, double* columns) {
    const std::size_t length = v.getLocalLength();
    for (std::size_t j = 0; j < v.getNumVectors(); ++j) {
      const auto view = v.getVector(j)->getLocalViewHost(Tpetra::Access::ReadOnly);
      std::copy_n(view.data(), length, columns + j * length);
    }
  }
  static void copy_to(const double* columns, Vector& v) {
    const std::size_t length = v.getLocalLength();
    for (std::size_t j = 0; j < v.getNumVectors(); ++j) {
      const auto view = v.getVectorNonConst(j)->getLocalViewHost(Tpetra::Access::OverwriteAll);
      std::copy_n(columns + j * length, length, view.data());
    }
  }
  static std::int64_t local_length(const Vector& v) { return static_cast<std::int64_t>(v.getLocalLength()); }

 private:
  template <class View>
  static auto columns_of(const View& view, std::shared_ptr<const void>& hold, bool device) {
    hold = keep(view);
    return LocalColumns<typename View::value_type>{view.data(), static_cast<std::int64_t>(view.stride(1)),
                                                   device};
  }
};

// ---- Epetra ----

#ifdef HAVE_AMESOS2_EPETRA

using EpetraMap = std::shared_ptr<const Epetra_BlockMap>;

inline std::vector<std::int64_t> ids(const EpetraMap& map) {
  std::vector<std::int64_t> all(map->NumMyElements());
  for (int k = 0; k < map->NumMyElements(); ++k) all[k] = map->GID64(k);
  return all;
}

inline bool same(const EpetraMap& a, const EpetraMap& b) {
  return a->SameAs(*b);
}

template <>
struct MatrixAccess<Epetra_CrsMatrix> {
  using Map = EpetraMap;
  static constexpr bool kOnDevice = false;
  struct DevicePattern {};

  static Map row_map(const Epetra_CrsMatrix& a) { return std::make_shared<Epetra_BlockMap>(a.RowMap()); }
  static Map column_map(const Epetra_CrsMatrix& a) { return std::make_shared<Epetra_BlockMap>(a.ColMap()); }
  static Map unknown_map(const Epetra_CrsMatrix& a) {
    return std::make_shared<Epetra_BlockMap>(a.DomainMap());
  }
  static bool complete(const Epetra_CrsMatrix& a) { return a.Filled(); }

  /// A copy: rows of an Epetra matrix need not lie together.
  static LocalRows rows(const Epetra_CrsMatrix& a) {
    struct Storage {
      std::vector<std::int64_t> offsets;
      std::vector<std::int32_t> columns;
      std::vector<double> values;
    };
    const auto storage = std::make_shared<Storage>();
    storage->offsets.push_back(0);
    storage->columns.reserve(a.NumMyNonzeros());
    storage->values.reserve(a.NumMyNonzeros());
    for (int row = 0; row < a.NumMyRows(); ++row) {
      int count = 0;
      int* columns = nullptr;
      double* values = nullptr;
      if (a.ExtractMyRowView(row, count, values, columns) != 0)
        throw std::invalid_argument("MFS: row " + std::to_string(row) +
                                    " of the Epetra matrix is not readable");
      storage->columns.insert(storage->columns.end(), columns, columns + count);
      storage->values.insert(storage->values.end(), values, values + count);
      storage->offsets.push_back(static_cast<std::int64_t>(storage->columns.size()));
    }
    return {a.NumMyRows(), storage->offsets.data(), storage->columns.data(), storage->values.data(), storage};
  }
};

template <>
struct VectorAccess<Epetra_MultiVector> {
  using Map = EpetraMap;

  static Map map(const Epetra_MultiVector& v) { return std::make_shared<Epetra_BlockMap>(v.Map()); }
  static std::int64_t length(const Epetra_MultiVector& v) { return v.GlobalLength64(); }
  static std::int64_t columns(const Epetra_MultiVector& v) { return v.NumVectors(); }
  /// Several entries per global id have no counterpart in the rows of an Epetra_CrsMatrix.
  static bool supported(const Epetra_MultiVector& v) {
    return v.Map().ConstantElementSize() && v.Map().ElementSize() == 1;
  }
  static bool one_distance(const Epetra_MultiVector& v) { return v.ConstantStride(); }
  static LocalColumns<const double> read(const Epetra_MultiVector& v, std::shared_ptr<const void>&, bool) {
    if (!one_distance(v)) return {};
    return {v.Values(), v.Stride()};
  }
  static LocalColumns<double> write(Epetra_MultiVector& v, std::shared_ptr<const void>&, bool) {
    if (!one_distance(v)) return {};
    return {v.Values(), v.Stride()};
  }
  static void copy_from(const Epetra_MultiVector& v, double* columns) {
    for (int j = 0; j < v.NumVectors(); ++j)
      std::copy_n(v[j], v.MyLength(), columns + static_cast<std::int64_t>(j) * v.MyLength());
  }
  static void copy_to(const double* columns, Epetra_MultiVector& v) {
    for (int j = 0; j < v.NumVectors(); ++j)
      std::copy_n(columns + static_cast<std::int64_t>(j) * v.MyLength(), v.MyLength(), v[j]);
  }
  static std::int64_t local_length(const Epetra_MultiVector& v) { return v.MyLength(); }
};

#endif  // HAVE_AMESOS2_EPETRA

}  // namespace mfs::amesos2
