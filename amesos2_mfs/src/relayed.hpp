// An error of mfs/error.hpp with a text of its own: the place is the caller's (global ids), or the error
// comes from another rank, where its text was composed already.
#pragma once

#include <string>
#include <utility>

namespace mfs::amesos2 {

template <class Error>
class Relayed : public Error {
 public:
  /// `arguments` are those of Error's constructor.
  template <class... Arguments>
  explicit Relayed(std::string text, Arguments&&... arguments)
      : Error(std::forward<Arguments>(arguments)...), text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

}  // namespace mfs::amesos2
