// What a device does in a refactorization and in a solve, and when: for each case and limit of memory a JSON
// line with all kernels and copies as the runtime itself records them (CUPTI's activity records), in seconds
// from the begin of the call. perf/study timeline makes a table and a picture of it, as Fig. 15 of the paper.
//
//   perf_timeline --memory-limit 0 --memory-limit 6GB elas3d:40
#include <cupti.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <mfs/mfs.hpp>

#include "ordering/stopwatch.hpp"
#include "perf/candidate.hpp"
#include "perf/command.hpp"
#include "perf/device_info.hpp"
#include "perf/measure.hpp"

namespace {

using Json = nlohmann::ordered_json;
using namespace mfs::perf;

#if CUPTI_API_VERSION >= 130000
using KernelRecord = CUpti_ActivityKernel10;
using CopyRecord = CUpti_ActivityMemcpy6;
#else
using KernelRecord = CUpti_ActivityKernel9;
using CopyRecord = CUpti_ActivityMemcpy5;
#endif

void check(CUptiResult status, const char* what) {
  const char* text = "";
  if (status == CUPTI_SUCCESS) return;
  cuptiGetResultString(status, &text);
  throw std::runtime_error(std::string(what) + ": " + text);
}

struct Activity {
  const char* kind;  // kernel, out, in or copy
  std::uint64_t begin, end, bytes;
};

/// What the device did since the last call of `taken`. One at a time: CUPTI has one receiver of its buffers.
class Recorder {
 public:
  /// Before the first use of the device, so that kernels of graphs are recorded each by itself.
  Recorder() {
    check(cuptiActivityRegisterCallbacks(give_buffer, take_buffer), "cuptiActivityRegisterCallbacks");
    for (const CUpti_ActivityKind kind : {CUPTI_ACTIVITY_KIND_CONCURRENT_KERNEL, CUPTI_ACTIVITY_KIND_MEMCPY})
      check(cuptiActivityEnable(kind), "cuptiActivityEnable");
  }
  std::vector<Activity> taken() {
    check(cuptiActivityFlushAll(CUPTI_ACTIVITY_FLAG_FLUSH_FORCED), "cuptiActivityFlushAll");
    return std::exchange(recorded(), {});
  }

 private:
  static std::vector<Activity>& recorded() {
    static std::vector<Activity> all;
    return all;
  }
  static void CUPTIAPI give_buffer(std::uint8_t** buffer, std::size_t* size, std::size_t* most) {
    constexpr std::size_t kBytes = 8 << 20;
    *buffer = static_cast<std::uint8_t*>(std::malloc(kBytes));
    *size = *buffer ? kBytes : 0;
    *most = 0;
  }
  static void CUPTIAPI take_buffer(CUcontext, std::uint32_t, std::uint8_t* buffer, std::size_t,
                                   std::size_t bytes) {
    CUpti_Activity* record = nullptr;
    while (cuptiActivityGetNextRecord(buffer, bytes, &record) == CUPTI_SUCCESS) {
      if (record->kind == CUPTI_ACTIVITY_KIND_CONCURRENT_KERNEL) {
        const auto* const kernel = reinterpret_cast<const KernelRecord*>(record);
        recorded().push_back({"kernel", kernel->start, kernel->end, 0});
      } else if (record->kind == CUPTI_ACTIVITY_KIND_MEMCPY) {
        const auto* const copy = reinterpret_cast<const CopyRecord*>(record);
        const char* const kind = copy->copyKind == CUPTI_ACTIVITY_MEMCPY_KIND_DTOH   ? "out"
                                 : copy->copyKind == CUPTI_ACTIVITY_MEMCPY_KIND_HTOD ? "in"
                                                                                     : "copy";
        recorded().push_back({kind, copy->start, copy->end, copy->bytes});
      }
    }
    std::free(buffer);
  }
};

/// The third time that `call` is made: then graphs are recorded, and nothing is taken.
template <class Call>
Json record(Recorder& recorder, const Call& call) {
  for (int warm = 0; warm < 2; ++warm) call();
  recorder.taken();
  std::uint64_t begin = 0;
  check(cuptiGetTimestamp(&begin), "cuptiGetTimestamp");
  const mfs::Stopwatch watch;
  call();
  const double seconds = watch.seconds();
  Json activities = Json::array();
  for (const Activity& activity : recorder.taken()) {
    const auto since = [&](std::uint64_t time) { return 1e-9 * static_cast<double>(time - begin); };
    activities.push_back({activity.kind, since(activity.begin), since(activity.end), activity.bytes});
  }
  return {{"seconds", seconds}, {"activities", activities}};
}

Json measure_case(Recorder& recorder, const std::string& name, std::int64_t limit, int threads) {
  const System system = make_system(name, threads);
  const std::unique_ptr<Candidate> candidate = make_mfs(system, mfs::Backend::cuda, threads, limit);
  candidate->analyze();
  candidate->factor();
  Json line{{"case", mfs::io::bench_case_name(name)}, {"limit", limit}, {"device", device_name()}};
  line["refactor"] = record(recorder, [&] { candidate->refactor(); });
  line["solve"] = record(recorder, [&] { candidate->solve(1); });
  const Facts facts = candidate->facts();
  line.update({{"segments", facts.segments}, {"flops", facts.flops}, {"device_bytes", facts.device_bytes}});
  return line;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> cases;
  std::vector<std::uint64_t> limits;
  int threads = 16;
  CLI::App app("Kernels and copies of a refactorization and of a solve on a device, as JSON lines");
  app.add_option("cases", cases, "FAMILY:SIZE or a file, Matrix Market or PETSc binary")->required();
  app.add_option("--memory-limit", limits, "bytes of the device that MFS may use, once or more; 0: all")
      ->transform(CLI::AsSizeValue(true).description(""))
      ->allow_extra_args(false);
  app.add_option("--threads", threads, "of the host")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  return exit_status("perf_timeline", [&] {
    Recorder recorder;
    if (limits.empty()) limits.push_back(0);
    for (const std::string& name : cases) {
      for (const std::uint64_t limit : limits)
        print(measure_case(recorder, name, static_cast<std::int64_t>(limit), threads));
    }
    return true;
  });
}
