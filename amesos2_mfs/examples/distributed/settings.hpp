// Parameter files: XML as Stratimikos reads it, of which these parts are used:
//
//   Linear Solver Types -> Belos -> Solver Type, Solver Types
//   Preconditioner Type                    Ifpack2, FROSch or MueLu
//   Preconditioner Types -> <that type>    what the engine gets
#pragma once

#include <string>

#include <Teuchos_ParameterList.hpp>

#include "types.hpp"

namespace distributed {

struct Settings {
  std::string name;  ///< of the file, without folder and ending
  std::string krylov_type, engine_type;
  Teuchos::ParameterList krylov, engine;
};

/// Throws std::invalid_argument on all ranks where rank 0 has no such file. Collective.
void require_file(const std::string& path, const Comm& comm);

/// Read on rank 0. Throws std::exceptions where the file or one of the parts above is missing.
Settings read_settings(const std::string& path, const RCP<const Comm>& comm);

/// Another solver of Amesos2 wherever the list says "MFS"; the options of MFS go.
void replace_solver(Teuchos::ParameterList& list, const std::string& solver);

/// Sets an option of MFS in every list of such options, the innermost ones with the name "MFS".
template <class Value>
void set_mfs_option(Teuchos::ParameterList& list, const std::string& name, const Value& value) {
  bool innermost = list.name().size() >= 3 && list.name().substr(list.name().size() - 3) == "MFS";
  for (auto entry = list.begin(); entry != list.end(); ++entry) {
    if (!list.entry(entry).isList()) continue;
    if (list.name(entry) == "MFS") innermost = false;
    set_mfs_option(list.sublist(list.name(entry)), name, value);
  }
  if (innermost) list.set(name, value);
}

}  // namespace distributed
