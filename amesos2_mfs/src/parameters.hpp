// The parameter list of the adapter against mfs::Options.
#pragma once

#include <Teuchos_ParameterList.hpp>
#include <Teuchos_RCP.hpp>

#include <mfs/options.hpp>

namespace mfs::amesos2 {

/// All parameters with their defaults, documentation and validators (Amesos2::mfs_valid_parameters).
Teuchos::RCP<Teuchos::ParameterList> valid_parameters();

/// What a sublist "MFS" asks for.
struct Parameters {
  Options options;
  bool has_trans = false;  ///< "Trans" was given, and goes before Amesos2's "Transpose"
  bool transpose = false;
  int default_threads = 0;  ///< for mfs::set_default_threads, unless 0
};

/// `list` may name some of the parameters; the others take their defaults.
/// Throws Teuchos::Exceptions::InvalidParameter (or a class derived from it): unknown name, wrong type or
/// value.
Parameters read_parameters(const Teuchos::ParameterList& list);

/// Both lists ask for the same options, so that an analysis made under one serves the other.
bool same_options(const Teuchos::ParameterList& a, const Teuchos::ParameterList& b);

}  // namespace mfs::amesos2
