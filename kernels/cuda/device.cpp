#include "kernels/cuda/device.hpp"

#include <mfs/error.hpp>

namespace mfs::cuda {

void check(cudaError_t code, const char* what) {
  if (code == cudaSuccess) return;
  cudaGetLastError();  // an error that is no fault of the device is forgotten: the next call may succeed
  throw BackendError("CUDA", code, std::string(what) + ": " + cudaGetErrorString(code));
}

void check_launch(const char* what) {
  check(cudaPeekAtLastError(), what);
}

Offset free_memory() {
  std::size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return static_cast<Offset>(free);
}

void set_shared_memory(const void* kernel, std::size_t bytes) {
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)),
        "cudaFuncSetAttribute");
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributePreferredSharedMemoryCarveout,
                             cudaSharedmemCarveoutMaxShared),
        "cudaFuncSetAttribute");
}

DeviceArena::DeviceArena(Offset bytes) : bytes_(bytes) {
  const cudaError_t code = cudaMalloc(&data_, static_cast<std::size_t>(bytes));
  if (code == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(bytes),
                      static_cast<std::size_t>(free_memory()));
  }
  check(code, "cudaMalloc");
}
DeviceArena::~DeviceArena() {
  cudaFree(data_);
}

PinnedArena::PinnedArena(Offset bytes) : bytes_(bytes) {
  const cudaError_t code = cudaMallocHost(&data_, static_cast<std::size_t>(bytes));
  if (code == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw std::bad_alloc();
  }
  check(code, "cudaMallocHost");
}
PinnedArena::~PinnedArena() {
  cudaFreeHost(data_);
}

Stream::Stream() {
  check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
}
Stream::~Stream() {
  cudaStreamDestroy(stream_);
}
void Stream::synchronize() const {
  check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize");
}
void Stream::wait_for(const Event& event) const {
  check(cudaStreamWaitEvent(stream_, event.get(), 0), "cudaStreamWaitEvent");
}
void Stream::to_device(void* to, const void* from, Offset bytes) const {
  check(cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyHostToDevice, stream_),
        "cudaMemcpy");
}
void Stream::to_host(void* to, const void* from, Offset bytes) const {
  check(cudaMemcpyAsync(to, from, static_cast<std::size_t>(bytes), cudaMemcpyDeviceToHost, stream_),
        "cudaMemcpy");
}
void Stream::fill(void* place, int byte, Offset bytes) const {
  check(cudaMemsetAsync(place, byte, static_cast<std::size_t>(bytes), stream_), "cudaMemset");
}

Event::Event() {
  check(cudaEventCreate(&event_), "cudaEventCreate");
}
Event::~Event() {
  cudaEventDestroy(event_);
}
void Event::record(const Stream& stream) {
  check(cudaEventRecord(event_, stream.get()), "cudaEventRecord");
}
void Event::record_foreign(void* stream) {
  check(cudaEventRecord(event_, static_cast<cudaStream_t>(stream)), "cudaEventRecord");
}
float Event::since(const Event& before) const {
  float milliseconds = 0;
  check(cudaEventElapsedTime(&milliseconds, before.event_, event_), "cudaEventElapsedTime");
  return milliseconds;
}

void Stream::copy_columns(void* to, Offset to_pitch, const void* from, Offset from_pitch, Offset bytes,
                          Vertex columns) const {
  check(cudaMemcpy2DAsync(to, static_cast<std::size_t>(to_pitch), from, static_cast<std::size_t>(from_pitch),
                          static_cast<std::size_t>(bytes), static_cast<std::size_t>(columns),
                          cudaMemcpyDefault, stream_),
        "cudaMemcpy2D");
}

void Graph::begin(const Stream& stream) {
  check(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeThreadLocal), "cudaStreamBeginCapture");
}
void Graph::abandon(const Stream& stream) {
  cudaGraph_t graph = nullptr;
  cudaStreamEndCapture(stream.get(), &graph);
  if (graph) cudaGraphDestroy(graph);
  cudaGetLastError();
}
void Graph::end(const Stream& stream) {
  cudaGraph_t graph = nullptr;
  check(cudaStreamEndCapture(stream.get(), &graph), "cudaStreamEndCapture");
  const cudaError_t code = cudaGraphInstantiate(&executable_, graph, 0);
  cudaGraphDestroy(graph);
  check(code, "cudaGraphInstantiate");
}
void Graph::launch(const Stream& stream) const {
  check(cudaGraphLaunch(executable_, stream.get()), "cudaGraphLaunch");
}
void Graph::reset() {
  if (executable_) cudaGraphExecDestroy(executable_);
  executable_ = nullptr;
}

}  // namespace mfs::cuda
