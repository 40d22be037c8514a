// "elas3d, beam3d, kkt": the words that would have been right, for messages.
#pragma once

#include <string>
#include <string_view>

namespace mfs {

/// Of each element of a map, or of pairs.
constexpr auto key_of = [](const auto& element) { return std::string_view(element.first); };

/// `word` gives what stands in the list for an element.
template <class Range, class Word>
std::string comma_list(const Range& elements, const Word& word) {
  std::string list;
  for (const auto& element : elements) {
    if (!list.empty()) list += ", ";
    list += word(element);
  }
  return list;
}

template <class Range>
std::string comma_list(const Range& words) {
  return comma_list(words, [](std::string_view word) { return word; });
}

}  // namespace mfs
