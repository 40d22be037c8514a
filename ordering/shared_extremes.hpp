// The largest or least value that several threads find, whatever their order.
#pragma once

namespace mfs {

/// target = value where better(value, target), while other threads do the same.
template <class T, class Better>
void improve(T& target, T value, const Better& better) {
  T now = __atomic_load_n(&target, __ATOMIC_RELAXED);
  while (better(value, now) &&
         !__atomic_compare_exchange_n(&target, &now, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
}

}  // namespace mfs
