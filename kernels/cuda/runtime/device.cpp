#include "kernels/cuda/runtime/device.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include <mfs/error.hpp>

#include "kernels/cuda/runtime/faults.hpp"

namespace mfs::cuda {

Fault* planned_fault = nullptr;

namespace {

// The call's result, or what a test wants it to be.
template <class Call>
cudaError_t attempt(CallKind kind, const Call& call) {
  if (!fails(kind)) return call();
  return kind == CallKind::runtime ? cudaErrorUnknown : cudaErrorMemoryAllocation;
}
template <class Call>
void checked(const char* what, const Call& call) {
  check(attempt(CallKind::runtime, call), what);
}

}  // namespace

void check(cudaError_t code, const char* what) {
  if (code == cudaSuccess) return;
  cudaGetLastError();  // an error that is no fault of the device is forgotten: the next call may succeed
  throw BackendError("CUDA", code, std::string(what) + ": " + cudaGetErrorString(code));
}

void check_launch(const char* what) {
  checked(what, [] { return cudaPeekAtLastError(); });
}

namespace {

struct MemoryInfo {
  std::size_t free = 0, total = 0;
};
MemoryInfo memory_info() {
  MemoryInfo info;
  checked("cudaMemGetInfo", [&] { return cudaMemGetInfo(&info.free, &info.total); });
  return info;
}

constexpr Offset kMostContext = Offset(1) << 30;  // on H100 some 0.6 GB
std::atomic<Offset> bytes_of_arenas{0}, least_context{kMostContext};

}  // namespace

Offset free_memory() {
  return static_cast<Offset>(memory_info().free);
}

Offset bytes_of_context() {
  const MemoryInfo info = memory_info();
  const Offset now = std::max<Offset>(static_cast<Offset>(info.total - info.free) - bytes_of_arenas, 0);
  Offset least = least_context;
  while (now < least && !least_context.compare_exchange_weak(least, now)) {
  }
  return std::min(now, least);
}

int device_count() {
  int count = 0;
  const cudaError_t code = cudaGetDeviceCount(&count);
  if (code != cudaSuccess) cudaGetLastError();
  return code == cudaSuccess ? count : 0;
}

int current_device() {
  int device = 0;
  checked("cudaGetDevice", [&] { return cudaGetDevice(&device); });
  return device;
}

namespace {

int attribute(cudaDeviceAttr which) {
  int value = 0;
  checked("cudaDeviceGetAttribute", [&] { return cudaDeviceGetAttribute(&value, which, current_device()); });
  return value;
}
cudaDeviceProp properties() {
  cudaDeviceProp found;
  checked("cudaGetDeviceProperties", [&] { return cudaGetDeviceProperties(&found, current_device()); });
  return found;
}

}  // namespace

void require_reachable(const void* array, const char* name) {
  cudaPointerAttributes found{};
  checked("cudaPointerGetAttributes", [&] { return cudaPointerGetAttributes(&found, array); });
  const int device = current_device();
  if (found.type == cudaMemoryTypeUnregistered && attribute(cudaDevAttrPageableMemoryAccess) == 0)
    throw InvalidInput(
        name, "lies in memory of the host, which device " + std::to_string(device) + " cannot reach");
  if (found.type == cudaMemoryTypeDevice && found.device != device)
    throw InvalidInput(name, "lies on device " + std::to_string(found.device) + ", the factors on device " +
                                 std::to_string(device));
}

OnDevice::OnDevice(int device) : before_(current_device()) {
  checked("cudaSetDevice", [&] { return cudaSetDevice(device); });
}
OnDevice::~OnDevice() {
  cudaSetDevice(before_);
}

int multiprocessors() {
  return attribute(cudaDevAttrMultiProcessorCount);
}

int shared_memory_per_block() {
  const int bytes = attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  const char* less = std::getenv("MFS_CUDA_SHARED_MEMORY");
  return less ? std::min(bytes, std::atoi(less)) : bytes;
}

std::string device_name() {
  return properties().name;
}
Offset device_memory() {
  return static_cast<Offset>(properties().totalGlobalMem);
}
int compute_capability() {
  return 10 * attribute(cudaDevAttrComputeCapabilityMajor) + attribute(cudaDevAttrComputeCapabilityMinor);
}
int single_to_double() {
  return attribute(cudaDevAttrSingleToDoublePrecisionPerfRatio);
}

int code_of(const void* kernel) {
  cudaFuncAttributes attributes{};
  checked("cudaFuncGetAttributes", [&] { return cudaFuncGetAttributes(&attributes, kernel); });
  return attributes.ptxVersion;
}

bool begins_early(const void* kernel) {
  constexpr int kLeastCode = 90, kLeastVersion = 12030;
  int driver = 0, runtime = 0;
  checked("cudaDriverGetVersion", [&] { return cudaDriverGetVersion(&driver); });
  checked("cudaRuntimeGetVersion", [&] { return cudaRuntimeGetVersion(&runtime); });
  return std::min(driver, runtime) >= kLeastVersion && code_of(kernel) >= kLeastCode;
}

void set_shared_memory(const void* kernel, std::size_t bytes) {
  checked("cudaFuncSetAttribute", [&] {
    return cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes));
  });
  checked("cudaFuncSetAttribute", [&] {
    return cudaFuncSetAttribute(kernel, cudaFuncAttributePreferredSharedMemoryCarveout,
                                cudaSharedmemCarveoutMaxShared);
  });
}

DeviceArena::DeviceArena(Offset bytes) : RawArena(bytes) {
  const cudaError_t code =
      attempt(CallKind::device_memory, [&] { return cudaMalloc(&data_, static_cast<std::size_t>(bytes)); });
  if (code == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(bytes),
                      static_cast<std::size_t>(free_memory()));
  }
  check(code, "cudaMalloc");
  bytes_of_arenas += bytes;
}
DeviceArena::~DeviceArena() {
  cudaFree(data_);
  bytes_of_arenas -= bytes();
}

constexpr Offset kPage = 4096;

// Whole pages, which all threads bring into being before they are locked: cudaMallocHost takes half a
// millisecond for a megabyte. At least one, as nothing cannot be locked.
PinnedArena::PinnedArena(Offset bytes)
    : RawArena(bytes), memory_((std::max(bytes, Offset(1)) + kPage - 1) / kPage * kPage) {
  data_ = memory_.at<char>(0);
#pragma omp parallel for schedule(static)
  for (Offset page = 0; page < memory_.bytes(); page += kPage) *at<char>(page) = 0;
  const cudaError_t code = attempt(CallKind::host_memory, [&] {
    return cudaHostRegister(data_, static_cast<std::size_t>(memory_.bytes()), cudaHostRegisterDefault);
  });
  if (code == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw std::bad_alloc();
  }
  check(code, "cudaHostRegister");
}
PinnedArena::~PinnedArena() {
  cudaHostUnregister(data_);
}

Stream::Stream(Priority priority) {
  checked("cudaStreamCreate", [&] {
    int least = 0, greatest = 0;
    const cudaError_t status = cudaDeviceGetStreamPriorityRange(&least, &greatest);
    if (status != cudaSuccess) return status;
    return cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking,
                                        priority == Priority::low ? least : greatest);
  });
}
Stream::~Stream() {
  cudaStreamDestroy(stream_);
}
void Stream::synchronize() const {
  checked("cudaStreamSynchronize", [&] { return cudaStreamSynchronize(stream_); });
}
void Stream::drain() const noexcept {
  cudaStreamSynchronize(stream_);
  cudaGetLastError();
}
void Stream::wait_for(const Event& event) const {
  checked("cudaStreamWaitEvent", [&] { return cudaStreamWaitEvent(stream_, event.get(), 0); });
}
void Stream::to_device(void* to, const void* from, Offset bytes) const {
  checked("cudaMemcpy", [&] {
    return cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyHostToDevice, stream_);
  });
}
void Stream::to_host(void* to, const void* from, Offset bytes) const {
  checked("cudaMemcpy", [&] {
    return cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyDeviceToHost, stream_);
  });
}
void Stream::fill(void* place, int byte, Offset bytes) const {
  if (bytes == 0) return;
  checked("cudaMemset",
          [&] { return cudaMemsetAsync(place, byte, static_cast<std::size_t>(bytes), stream_); });
}

void Upload::to_device(void* to, const void* from, Offset bytes) {
  constexpr Offset kAtOnce = 1 << 16;  // of a thread
  for (Offset done = 0; done < bytes;) {
    if (used_ == half_bytes_) turn();
    const Offset some = std::min(bytes - done, half_bytes_ - used_);
    char* const stage = memory_.at<char>(half_ * half_bytes_ + used_);
    const char* const source = static_cast<const char*>(from) + done;
#pragma omp parallel for schedule(static) if (some > 4 * kAtOnce)
    for (Offset k = 0; k < some; k += kAtOnce)
      std::memcpy(stage + k, source + k, static_cast<std::size_t>(std::min(kAtOnce, some - k)));
    stream_.to_device(static_cast<char*>(to) + done, stage, some);
    used_ += some;
    done += some;
  }
}
void Upload::turn() {
  copied_[half_].record(stream_);
  half_ = 1 - half_;
  copied_[half_].synchronize();  // at once, before it has been recorded
  used_ = 0;
}

Event::Event() {
  checked("cudaEventCreate", [&] { return cudaEventCreate(&event_); });
}
Event::~Event() {
  cudaEventDestroy(event_);
}
void Event::record(const Stream& stream) {
  checked("cudaEventRecord", [&] { return cudaEventRecord(event_, stream.get()); });
}
void Event::record_foreign(void* stream) {
  checked("cudaEventRecord", [&] { return cudaEventRecord(event_, static_cast<cudaStream_t>(stream)); });
}
void Event::synchronize() const {
  checked("cudaEventSynchronize", [&] { return cudaEventSynchronize(event_); });
}
float Event::since(const Event& before) const {
  float milliseconds = 0;
  checked("cudaEventElapsedTime", [&] { return cudaEventElapsedTime(&milliseconds, before.event_, event_); });
  return milliseconds;
}

void Stream::copy_columns(void* to, Offset to_pitch, const void* from, Offset from_pitch, Offset bytes,
                          Vertex columns) const {
  checked("cudaMemcpy2D", [&] {
    return cudaMemcpy2DAsync(to, static_cast<std::size_t>(to_pitch), from,
                             static_cast<std::size_t>(from_pitch), static_cast<std::size_t>(bytes),
                             static_cast<std::size_t>(columns), cudaMemcpyDefault, stream_);
  });
}

void Graph::begin(const Stream& stream) {
  checked("cudaStreamBeginCapture",
          [&] { return cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeThreadLocal); });
}
void Graph::abandon(const Stream& stream) {
  cudaGraph_t graph = nullptr;
  cudaStreamEndCapture(stream.get(), &graph);
  if (graph) cudaGraphDestroy(graph);
  cudaGetLastError();
}
void Graph::end(const Stream& stream) {
  cudaGraph_t graph = nullptr;
  checked("cudaStreamEndCapture", [&] { return cudaStreamEndCapture(stream.get(), &graph); });
  const cudaError_t code = attempt(CallKind::runtime, [&] {
    return cudaGraphInstantiate(&executable_, graph, cudaGraphInstantiateFlagUseNodePriority);
  });
  cudaGraphDestroy(graph);
  check(code, "cudaGraphInstantiate");
}
void Graph::launch(const Stream& stream) const {
  checked("cudaGraphLaunch", [&] { return cudaGraphLaunch(executable_, stream.get()); });
}
void Graph::reset() {
  if (executable_) cudaGraphExecDestroy(executable_);
  executable_ = nullptr;
}

}  // namespace mfs::cuda
