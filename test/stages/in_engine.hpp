#pragma once

#include "kernels/runtime/engine.hpp"

namespace mfs::test {

/// Work that uses Kokkos, where it runs in MFS.
template <class Work>
void in_engine(int threads, const Work& work) {
  Engine::instance().run(threads, [&work] { work(); });
}

}  // namespace mfs::test
