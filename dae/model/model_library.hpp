// The models that come with the program: the three experiments of Jung and Bae (Multibody System Dynamics
// 2017), as the files in dae/model/library.
#pragma once

#include <string>
#include <vector>

namespace mfs::dae {

struct LibraryModel {
  std::string name;
  std::string text;  ///< of its JSON file
};

const std::vector<LibraryModel>& model_library();

}  // namespace mfs::dae
