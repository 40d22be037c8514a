// The models that come with the program, as the files in dae/model/library: the three experiments of Jung and
// Bae (Multibody System Dynamics 2017) and known mechanisms (docs/mechanisms.md).
#pragma once

#include <string>
#include <vector>

namespace mfs::dae {

struct LibraryModel {
  std::string name;
  std::string text;  ///< of its JSON file
};

const std::vector<LibraryModel>& model_library();
/// Null: there is none of that name.
const LibraryModel* find_library_model(const std::string& name);

}  // namespace mfs::dae
