#include "test/failure/counted_memory.hpp"

#include <malloc.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> counting{false}, failed{false};
std::atomic<long> count{0}, victim{-1}, live{0};
std::atomic<std::size_t> refused_size{SIZE_MAX};
std::atomic<std::size_t> bytes_now{0}, peak{0}, largest{0};

void raise(std::atomic<std::size_t>& mark, std::size_t value) {
  std::size_t seen = mark;
  while (seen < value && !mark.compare_exchange_weak(seen, value)) {
  }
}

void* allocate(std::size_t bytes, std::size_t alignment) {
  bool refuse = bytes >= refused_size;
  if (counting) refuse |= count.fetch_add(1) == victim;
  if (refuse) {
    failed = true;
    throw std::bad_alloc();
  }
  void* memory = nullptr;
  if (alignment <= alignof(std::max_align_t)) {
    memory = std::malloc(bytes ? bytes : 1);
  } else {
    memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  }
  if (!memory) throw std::bad_alloc();
  ++live;
  raise(largest, bytes);
  raise(peak, bytes_now += malloc_usable_size(memory));
  return memory;
}

void* allocate_or_null(std::size_t bytes, std::size_t alignment) noexcept {
  try {
    return allocate(bytes, alignment);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void release(void* memory) noexcept {
  if (!memory) return;
  --live;
  bytes_now -= malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t bytes) {
  return allocate(bytes, 1);
}
void* operator new[](std::size_t bytes) {
  return allocate(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t a) {
  return allocate(bytes, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t bytes, std::align_val_t a) {
  return allocate(bytes, static_cast<std::size_t>(a));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 1);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 1);
}
void operator delete(void* memory) noexcept {
  release(memory);
}
void operator delete[](void* memory) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  release(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  release(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  release(memory);
}

namespace mfs::test {

void start_counting(long fail_at) {
  failed = false;
  count = 0;
  victim = fail_at;
  counting = true;
}

void fail_large_ones(std::size_t bytes) {
  failed = false;
  refused_size = bytes;
}

long stop_counting() {
  counting = false;
  victim = -1;
  refused_size = SIZE_MAX;
  return count;
}

bool one_has_failed() {
  return failed;
}

long live_blocks() {
  return live;
}

std::size_t live_bytes() {
  return bytes_now;
}

void restart_marks() {
  largest = 0;
  peak = bytes_now.load();
}

std::size_t peak_bytes() {
  return peak;
}

std::size_t largest_request() {
  return largest;
}

}  // namespace mfs::test
