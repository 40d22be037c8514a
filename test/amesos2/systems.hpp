// Small systems for the tests of the adapter: matrices from lists of entries, on any number of ranks.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <Teuchos_CommHelpers.hpp>
#include <Tpetra_Core.hpp>
#include <Tpetra_CrsMatrix.hpp>
#include <Tpetra_MultiVector.hpp>

namespace mfs::test {

using Teuchos::RCP;
using Teuchos::rcp;
using Matrix = Tpetra::CrsMatrix<double>;
using Vector = Tpetra::MultiVector<double>;
using Map = Tpetra::Map<>;
using Ordinal = Map::global_ordinal_type;

/// (row, column) -> value, by global ids; the same list on every rank.
using Entries = std::map<std::pair<Ordinal, Ordinal>, double>;
using Ids = std::vector<Ordinal>;

inline RCP<const Teuchos::Comm<int>> world() {
  return Tpetra::getDefaultComm();
}

/// Ids 0 ... n-1 in pieces of equal size.
inline RCP<const Map> even_map(Ordinal n, Ordinal base = 0) {
  return rcp(new Map(static_cast<Tpetra::global_size_t>(n), base, world()));
}

/// These ids dealt to the ranks like cards, so that rank order is not the order of the list.
inline RCP<const Map> dealt_map(const Ids& ids) {
  Teuchos::Array<Ordinal> mine;
  for (std::size_t k = 0; k < ids.size(); ++k)
    if (static_cast<int>(k) % world()->getSize() == world()->getRank()) mine.push_back(ids[k]);
  return rcp(new Map(static_cast<Tpetra::global_size_t>(ids.size()), mine(), 0, world()));
}

/// An unsymmetric grid operator of nx * ny unknowns, and what it becomes with other ids.
inline Entries grid_entries(Ordinal nx, Ordinal ny) {
  Entries entries;
  for (Ordinal y = 0; y < ny; ++y)
    for (Ordinal x = 0; x < nx; ++x) {
      const Ordinal row = x + nx * y;
      entries[{row, row}] = 4.0 + 0.1 * static_cast<double>(x);
      if (x > 0) entries[{row, row - 1}] = -1.3;
      if (x < nx - 1) entries[{row, row + 1}] = -0.7;
      if (y > 0) entries[{row, row - nx}] = -1.2;
      if (y < ny - 1) entries[{row, row + nx}] = -0.8;
    }
  return entries;
}

inline Entries renamed(const Entries& entries, const std::function<Ordinal(Ordinal)>& row_id,
                       const std::function<Ordinal(Ordinal)>& column_id) {
  Entries result;
  for (const auto& [place, value] : entries) result[{row_id(place.first), column_id(place.second)}] = value;
  return result;
}

/// Rows as `rows` spreads them; `domain` null: the same. Not yet fill-complete.
inline RCP<Matrix> open_matrix(const Entries& entries, const RCP<const Map>& rows) {
  const auto a = rcp(new Matrix(rows, 16));
  for (const auto& [place, value] : entries)
    if (rows->isNodeGlobalElement(place.first))
      a->insertGlobalValues(place.first, Teuchos::tuple(place.second), Teuchos::tuple(value));
  return a;
}

inline RCP<Matrix> assemble(const Entries& entries, const RCP<const Map>& rows,
                            const RCP<const Map>& domain = Teuchos::null) {
  const auto a = open_matrix(entries, rows);
  a->fillComplete(domain.is_null() ? rows : domain, rows);
  return a;
}

/// Some value for an id and a column.
inline double sample(Ordinal id, std::size_t column) {
  return 1.0 + 0.25 * static_cast<double>(id % 7) - 0.5 * static_cast<double>(column);
}

inline RCP<Vector> samples(const RCP<const Map>& map, std::size_t columns = 1) {
  const auto v = rcp(new Vector(map, columns));
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t i = 0; i < v->getLocalLength(); ++i)
      v->replaceLocalValue(static_cast<int>(i), j, sample(map->getGlobalElement(static_cast<int>(i)), j));
  return v;
}

/// A times the samples, or A^T times them.
inline RCP<Vector> image(const Matrix& a, std::size_t columns = 1,
                         Teuchos::ETransp mode = Teuchos::NO_TRANS) {
  const bool plain = mode == Teuchos::NO_TRANS;
  const auto x = samples(plain ? a.getDomainMap() : a.getRangeMap(), columns);
  const auto b = rcp(new Vector(plain ? a.getRangeMap() : a.getDomainMap(), columns));
  a.apply(*x, *b, mode);
  return b;
}

/// Largest distance of `x` from the samples, on all ranks; NaN stays NaN.
inline double distance_from_samples(const Vector& x) {
  Vector difference(x, Teuchos::Copy);
  difference.update(-1.0, *samples(x.getMap(), x.getNumVectors()), 1.0);
  double local = 0.0, worst = 0.0;
  for (std::size_t j = 0; j < x.getNumVectors(); ++j) {
    const auto column = difference.getVector(j)->getData();
    for (const double value : column)
      if (!(std::abs(value) <= local)) local = std::abs(value);
  }
  Teuchos::reduceAll(*world(), Teuchos::REDUCE_MAX, local, Teuchos::outArg(worst));
  return std::isnan(local) ? local : worst;
}

/// A list as Amesos2 wants it, with a sublist for MFS.
inline RCP<Teuchos::ParameterList> amesos2_parameters(
    const std::function<void(Teuchos::ParameterList&)>& fill = [](Teuchos::ParameterList&) {}) {
  const auto list = Teuchos::parameterList("Amesos2");
  fill(list->sublist("MFS"));
  return list;
}

}  // namespace mfs::test
