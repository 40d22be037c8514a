// Newton's matrix on the device (RemoteMatrix): cleared, given what the host has, then added to by each body
// in the body's own stream. Bodies have rows of their own, so they add at the same time and nothing is
// atomic.
#pragma once

#include <vector>

#include "dae/fem/cuda/device_body.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "kernels/cuda/runtime/device.hpp"

namespace mfs::dae {

/// values[place[k]] = own[k].
static __global__ void put_entries(std::int64_t count, const int* place, const double* own, double* values) {
  const std::int64_t k = static_cast<std::int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (k < count) values[place[k]] = own[k];
}

class DeviceMatrix final : public RemoteMatrix {
 public:
  DeviceMatrix(std::size_t entries, const std::vector<int>& own)
      : entries_(static_cast<Offset>(entries)),
        own_(static_cast<Offset>(own.size())),
        places_(entries, own.size()),
        device_(places_.layout.total()),
        host_(bytes_of(own.size())) {
    stream_.to_device(device_.at<int>(places_.place), own.data(), own_ * static_cast<Offset>(sizeof(int)));
    stream_.synchronize();  // what was borrowed may go
  }
  ~DeviceMatrix() override { stream_.drain(); }

  double* own() override {
    stream_.drain();  // the copy of those before
    return host_.at<double>(0);
  }
  void begin() override {
    constexpr int kThreads = 256;
    double* const own = device_.at<double>(places_.own);
    stream_.clear(at(), entries_ * static_cast<Offset>(sizeof(double)));
    if (own_ > 0) {
      stream_.to_device(own, host_.at<double>(0), own_ * static_cast<Offset>(sizeof(double)));
      put_entries<<<static_cast<unsigned>((own_ + kThreads - 1) / kThreads), kThreads, 0, stream_.get()>>>(
          own_, device_.at<int>(places_.place), own, at());
      cuda::check_launch("put_entries");
    }
    begun_.record(stream_);
  }
  const double* values() override { return at(); }
  void* stream() const override { return stream_.get(); }
  void read(double* values) override {
    stream_.to_host(values, at(), entries_ * static_cast<Offset>(sizeof(double)));
    stream_.synchronize();
  }

  /// Calls work(values), which puts what adds to them into the stream `by`, behind what has begun and before
  /// all that is put into stream() from now on.
  template <class Work>
  void add(const cuda::Stream& by, const Work& work) {
    by.wait_for(begun_);
    work(at());
    added_.record(by);
    stream_.wait_for(added_);
  }

 private:
  struct Places {
    ArenaLayout layout;
    Offset values, own, place;
    Places(std::size_t entries, std::size_t count)
        : values(layout.add(bytes_of(entries))),
          own(layout.add(bytes_of(count))),
          place(layout.add(static_cast<Offset>(count * sizeof(int)))) {}
  };
  double* at() const { return device_.at<double>(places_.values); }

  const Offset entries_, own_;
  const Places places_;
  cuda::Stream stream_;
  cuda::Event begun_, added_;
  const cuda::DeviceArena device_;
  const cuda::PinnedArena host_;  // what the host has
};

}  // namespace mfs::dae
