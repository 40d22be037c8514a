// Pieces of rows and columns.
#pragma once

#include "ordering/types.hpp"

namespace mfs {

struct Span {
  Vertex begin, end;
  Vertex length() const { return end - begin; }
};

inline Vertex tiles_of(Offset length, Vertex tile) {
  return static_cast<Vertex>((length + tile - 1) / tile);
}

}  // namespace mfs
