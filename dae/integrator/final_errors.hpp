// Which errors in a step end a run.
#pragma once

#include <exception>
#include <new>

#include <mfs/error.hpp>

namespace mfs::dae {

/// Throws what no shorter step can cure.
inline void rethrow_if_final(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InvalidInput&) {
    return;  // a NaN or Inf in the matrix, by too long a step
  } catch (const SingularMatrix&) {
    return;
  } catch (const AccuracyNotReached&) {
    return;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (...) {
    return;
  }
}

}  // namespace mfs::dae
