// Matrices of chains of rigid bodies with joints, as an implicit step of their equations has them: "chain:N",
// with 11 N + 2 unknowns.
#pragma once

#include <optional>
#include <string>

#include "cases/families.hpp"

namespace mfs::perf {

inline bool is_chain(const std::string& name) {
  return name.rfind("chain:", 0) == 0;
}

/// Nothing where `name` is not one of a chain. Throws std::invalid_argument for one of a single body.
std::optional<cases::FamilyMatrix> chain_of(const std::string& name);

}  // namespace mfs::perf
