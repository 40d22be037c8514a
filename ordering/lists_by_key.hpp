// Items in lists by a number that each has, in linear time.
#pragma once

#include <numeric>
#include <vector>

#include "ordering/types.hpp"

namespace mfs {

/// Items by their key: those of key g are item[begin[g]] ... item[begin[g + 1] - 1], ascending; key -1 is in
/// no list.
struct Lists {
  std::vector<Vertex> begin, item;
};
inline Lists lists_by_key(const std::vector<Vertex>& key, Vertex keys) {
  Lists lists;
  lists.begin.assign(static_cast<std::size_t>(keys) + 1, 0);
  for (const Vertex g : key) {
    if (g >= 0) ++lists.begin[g + 1];
  }
  std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
  lists.item.resize(lists.begin.back());
  std::vector<Vertex> next(lists.begin.begin(), lists.begin.end() - 1);
  for (std::size_t i = 0; i < key.size(); ++i) {
    if (key[i] >= 0) lists.item[next[key[i]]++] = static_cast<Vertex>(i);
  }
  return lists;
}

}  // namespace mfs
