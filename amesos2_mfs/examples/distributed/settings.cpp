#include "settings.hpp"

#include <filesystem>
#include <stdexcept>
#include <vector>

#include <Teuchos_CommHelpers.hpp>
#include <Teuchos_XMLParameterListHelpers.hpp>

namespace distributed {
namespace {

/// A sublist that has to be there.
Teuchos::ParameterList& required(Teuchos::ParameterList& list, const std::string& name) {
  if (!list.isSublist(name)) throw std::invalid_argument(list.name() + ": there is no list \"" + name + "\"");
  return list.sublist(name);
}

}  // namespace

void require_file(const std::string& path, const Comm& comm) {
  int there = comm.getRank() == 0 && std::filesystem::is_regular_file(path) ? 1 : 0;
  Teuchos::broadcast(comm, 0, Teuchos::outArg(there));
  if (!there) throw std::invalid_argument(path + ": no such file");
}

Settings read_settings(const std::string& path, const RCP<const Comm>& comm) {
  require_file(path, *comm);
  Teuchos::ParameterList all;
  Teuchos::updateParametersFromXmlFileAndBroadcast(path, Teuchos::Ptr<Teuchos::ParameterList>(&all), *comm);
  all.setName(path);
  Settings settings;
  settings.name = std::filesystem::path(path).stem();
  Teuchos::ParameterList& belos = required(required(all, "Linear Solver Types"), "Belos");
  settings.krylov_type = belos.get<std::string>("Solver Type");
  settings.krylov = required(required(belos, "Solver Types"), settings.krylov_type);
  settings.engine_type = all.get<std::string>("Preconditioner Type");
  settings.engine = required(required(all, "Preconditioner Types"), settings.engine_type);
  return settings;
}

void replace_solver(Teuchos::ParameterList& list, const std::string& solver) {
  std::vector<std::string> names;
  for (auto entry = list.begin(); entry != list.end(); ++entry) names.push_back(list.name(entry));
  for (const std::string& name : names) {
    if (!list.isSublist(name)) {
      if (list.isType<std::string>(name) && list.get<std::string>(name) == "MFS") list.set(name, solver);
    } else if (name == "MFS") {
      list.remove(name);
    } else {
      replace_solver(list.sublist(name), solver);
    }
  }
}

}  // namespace distributed
