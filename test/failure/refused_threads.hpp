// A system that grants this process no further thread.
#pragma once

#include <pthread.h>

#include <cstddef>

namespace mfs::test {

/// While it lives, every new thread asks for a stack larger than the address space.
class RefusedThreads {
 public:
  RefusedThreads() {
    pthread_attr_t attributes;
    pthread_getattr_default_np(&attributes);
    pthread_attr_getstacksize(&attributes, &usual_);
    pthread_attr_destroy(&attributes);
    set(std::size_t(1) << 47);
  }
  ~RefusedThreads() { set(usual_); }
  RefusedThreads(const RefusedThreads&) = delete;
  RefusedThreads& operator=(const RefusedThreads&) = delete;

 private:
  static void set(std::size_t bytes) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, bytes);
    pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
  }
  std::size_t usual_ = 0;
};

}  // namespace mfs::test
