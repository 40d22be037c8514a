#include "on_all_ranks.hpp"

#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <string>

#include <Teuchos_CommHelpers.hpp>

#include <mfs/error.hpp>

#include "relayed.hpp"

namespace mfs::amesos2 {
namespace {

enum class FailureClass : int {
  invalid_input,
  state,
  pattern_changed,
  singular,
  accuracy,
  out_of_memory,
  backend,
  invalid_argument,
  other,
};

/// An exception as numbers and two texts, so that it can travel.
struct Failure {
  struct Numbers {
    FailureClass failure_class = FailureClass::other;
    int detail = 0;  ///< kind of singularity, memory space, or code of the backend
    std::int64_t row = -1, column = -1, count = 0;
    std::uint64_t needed = 0, available = 0;
    double reached = 0, asked = 0;
    int text_length = 0, subject_length = 0;
  } numbers;
  std::string text;     ///< what()
  std::string subject;  ///< argument or library
};

/// Describes the exception that is being handled.
Failure describe_current_exception() {
  Failure failure;
  Failure::Numbers& numbers = failure.numbers;
  try {
    throw;
  } catch (const InvalidInput& e) {
    numbers.failure_class = FailureClass::invalid_input;
    numbers.row = e.row();
    numbers.column = e.column();
    failure.subject = e.argument();
    failure.text = e.what();
  } catch (const PatternChanged& e) {
    numbers.failure_class = FailureClass::pattern_changed;
    numbers.row = e.row();
    failure.text = e.what();
  } catch (const SingularMatrix& e) {
    numbers.failure_class = FailureClass::singular;
    numbers.detail = static_cast<int>(e.kind());
    numbers.row = e.row();
    numbers.column = e.column();
    numbers.count = e.dependent_rows();
    failure.text = e.what();
  } catch (const AccuracyNotReached& e) {
    numbers.failure_class = FailureClass::accuracy;
    numbers.reached = e.reached();
    numbers.asked = e.asked();
    failure.text = e.what();
  } catch (const OutOfMemory& e) {
    numbers.failure_class = FailureClass::out_of_memory;
    numbers.detail = static_cast<int>(e.space());
    numbers.needed = e.needed();
    numbers.available = e.available();
    failure.text = e.what();
  } catch (const BackendError& e) {
    numbers.failure_class = FailureClass::backend;
    numbers.detail = e.code();
    failure.subject = e.library();
    failure.text = e.what();
  } catch (const StateError& e) {
    numbers.failure_class = FailureClass::state;
    failure.text = e.what();
  } catch (const std::invalid_argument& e) {
    numbers.failure_class = FailureClass::invalid_argument;
    failure.text = e.what();
  } catch (const std::bad_alloc&) {
    numbers.failure_class = FailureClass::out_of_memory;
    numbers.detail = static_cast<int>(MemorySpace::host);
    failure.text = "MFS adapter: out of host memory";
  } catch (const std::exception& e) {
    failure.text = e.what();
  } catch (...) {
    failure.text = "MFS adapter: unknown exception";
  }
  return failure;
}

[[noreturn]] void throw_again(const Failure& failure) {
  const Failure::Numbers& numbers = failure.numbers;
  switch (numbers.failure_class) {
    case FailureClass::invalid_input:
      throw Relayed<InvalidInput>(failure.text, failure.subject, failure.text, numbers.row, numbers.column);
    case FailureClass::pattern_changed:
      throw Relayed<PatternChanged>(failure.text, failure.text, numbers.row);
    case FailureClass::singular:
      throw Relayed<SingularMatrix>(failure.text, static_cast<SingularMatrix::Kind>(numbers.detail),
                                    numbers.row, numbers.column, numbers.count, failure.text);
    case FailureClass::accuracy:
      throw Relayed<AccuracyNotReached>(failure.text, numbers.reached, numbers.asked);
    case FailureClass::out_of_memory:
      throw Relayed<OutOfMemory>(failure.text, static_cast<MemorySpace>(numbers.detail), numbers.needed,
                                 numbers.available);
    case FailureClass::backend:
      throw Relayed<BackendError>(failure.text, failure.subject, numbers.detail, failure.text);
    case FailureClass::state:
      throw StateError(failure.text);
    case FailureClass::invalid_argument:
      throw std::invalid_argument(failure.text);
    case FailureClass::other:
      break;
  }
  throw std::runtime_error(failure.text);
}

/// Makes `failure` of rank `source` known to all ranks. Collective.
void broadcast(const Teuchos::Comm<int>& comm, int source, Failure& failure) {
  failure.numbers.text_length = static_cast<int>(failure.text.size());
  failure.numbers.subject_length = static_cast<int>(failure.subject.size());
  char packed[sizeof(Failure::Numbers)];
  std::memcpy(packed, &failure.numbers, sizeof packed);
  comm.broadcast(source, static_cast<int>(sizeof packed), packed);
  std::memcpy(&failure.numbers, packed, sizeof packed);
  failure.text.resize(failure.numbers.text_length);
  failure.subject.resize(failure.numbers.subject_length);
  comm.broadcast(source, failure.numbers.text_length, failure.text.data());
  comm.broadcast(source, failure.numbers.subject_length, failure.subject.data());
}

}  // namespace

void on_all_ranks(const Teuchos::Comm<int>& comm, const std::function<void()>& work) {
  if (comm.getSize() == 1) {
    work();
    return;
  }
  Failure failure;
  int failing_rank = comm.getSize();  // none
  try {
    work();
  } catch (...) {
    failure = describe_current_exception();
    failing_rank = comm.getRank();
  }
  int first_failing_rank = failing_rank;
  Teuchos::reduceAll(comm, Teuchos::REDUCE_MIN, failing_rank, Teuchos::outArg(first_failing_rank));
  if (first_failing_rank == comm.getSize()) return;
  broadcast(comm, first_failing_rank, failure);
  throw_again(failure);
}

}  // namespace mfs::amesos2
