#include "solver/program/rates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>

#include <nlohmann/json.hpp>

#include <mfs/error.hpp>
#include <mfs/version.hpp>

#include "parts/output_file.hpp"

namespace mfs::program {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 4;

std::string host_processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string library_version(const std::string& name) {
  for (const LibraryInfo& library : libraries())
    if (library.name == name) return library.version;
  return "";
}

double time_of(const LevelTime& level, double fronts) {
  return level.alone + std::max(fronts - 1, 0.0) * level.each;
}

double clamped(double size, const MachineRates& rates) {
  return std::clamp(size, rates.fronts.front().size, rates.fronts.back().size);
}

LevelTime interpolated(const std::vector<FrontRate>& rates, LevelTime FrontRate::*time, double size) {
  const auto above =
      std::find_if(rates.begin(), rates.end(), [&](const FrontRate& r) { return r.size >= size; });
  if (above == rates.begin()) return rates.front().*time;
  if (above == rates.end()) return rates.back().*time;
  const FrontRate &low = *std::prev(above), &high = *above;
  const double part = std::log(size / low.size) / std::log(high.size / low.size);
  const auto mean = [&](double a, double b) {
    return std::exp((1 - part) * std::log(a) + part * std::log(b));
  };
  const LevelTime &a = low.*time, &b = high.*time;
  return {mean(a.alone, b.alone), mean(a.each, b.each)};
}

// Of a depth with so many entries of factors, of which those of its mean front are read while that waits for
// its pivots.
double device_solve(const MachineRates& rates, const FrontShape& front, double entries) {
  const double size = equivalent_size(front.pivots, 2 * front.pivots), known = clamped(size, rates);
  const LevelTime time = interpolated(rates.fronts, &FrontRate::solve, known);
  const double own = front.pivots * (front.pivots + 2 * front.border);
  return time.alone * std::max(size / known, 1.0) +
         std::max(entries - own, 0.0) * time.each / entries_of_front(known);
}

Json to_json(const MachineRates& rates) {
  Json fronts = Json::array();
  for (const FrontRate& rate : rates.fronts)
    fronts.push_back({{"size", rate.size},
                      {"flops_per_second", rate.flops_per_second},
                      {"entries_per_second", rate.entries_per_second},
                      {"refactor_alone", rate.refactor.alone},
                      {"refactor_each", rate.refactor.each},
                      {"solve_alone", rate.solve.alone},
                      {"solve_each", rate.solve.each}});
  return {{"processor", rates.key.processor},
          {"blas", rates.key.blas},
          {"backend", rates.key.backend},
          {"threads", rates.key.threads},
          {"date", rates.date},
          {"fronts", fronts},
          {"refactor_call", rates.refactor_call},
          {"solve_call", rates.solve_call},
          {"refactor_seconds_per_entry", rates.refactor_seconds_per_entry},
          {"solve_seconds_per_entry", rates.solve_seconds_per_entry},
          {"solve_seconds_per_row", rates.solve_seconds_per_row},
          {"link_bytes_per_second", rates.link_bytes_per_second}};
}

// Throws what the library of JSON throws, and std::domain_error.
MachineRates from_json(const Json& json) {
  MachineRates rates{{json.at("processor"), json.at("blas"), json.at("backend"), json.at("threads")},
                     json.at("date"),
                     {},
                     json.at("refactor_call"),
                     json.at("solve_call"),
                     json.at("refactor_seconds_per_entry"),
                     json.at("solve_seconds_per_entry"),
                     json.at("solve_seconds_per_row"),
                     json.at("link_bytes_per_second")};
  for (const double number :
       {rates.refactor_call, rates.solve_call, rates.refactor_seconds_per_entry,
        rates.solve_seconds_per_entry, rates.solve_seconds_per_row, rates.link_bytes_per_second})
    if (!(number >= 0) || !std::isfinite(number)) throw std::domain_error("a number that cannot be");
  double last = 0;
  for (const Json& front : json.at("fronts")) {
    const FrontRate rate{front.at("size"),
                         front.at("flops_per_second"),
                         front.at("entries_per_second"),
                         {front.at("refactor_alone"), front.at("refactor_each")},
                         {front.at("solve_alone"), front.at("solve_each")}};
    for (const double number : {rate.size, rate.flops_per_second, rate.entries_per_second,
                                rate.refactor.alone, rate.refactor.each, rate.solve.alone, rate.solve.each})
      if (!(number > 0) || !std::isfinite(number)) throw std::domain_error("a rate that none can be");
    if (!(rate.size > last)) throw std::domain_error("sizes that do not rise");
    last = rate.size;
    rates.fronts.push_back(rate);
  }
  if (rates.fronts.empty()) throw std::domain_error("no rates");
  return rates;
}

}  // namespace

bool RatesKey::operator==(const RatesKey& other) const {
  return std::tie(processor, blas, backend, threads) ==
         std::tie(other.processor, other.blas, other.backend, other.threads);
}

double equivalent_size(double p, double b) {
  return std::cbrt(p * p * p / 3 + p * p * b + p * b * b);
}

double flops_of_front(double size) {
  return 2 * size * size * size;
}

double entries_of_front(double size) {
  const double pivots = size / equivalent_size(1, 2);
  return 5 * pivots * pivots;
}

// Of sums over fronts of p pivots and b border rows: those of 2 p b^2 over those of 2 b^2 are a mean of p in
// which the large fronts count most, and over those of 2 p b a mean of b of the same kind. Products inside
// divided pivot blocks make them too large, and many small fronts the rest, so the largest front bounds both.
FrontShape mean_front(const DepthSummary& d) {
  const auto pivots = static_cast<double>(d.pivots), entries = static_cast<double>(d.factor_entries);
  if (!(pivots > 0)) return {};
  const auto largest = static_cast<double>(d.max_front);
  double p = std::min(entries / pivots, largest), b = 0;
  if (d.contribution_entries > 0) {
    p = std::min(d.flops.gemm / (2 * static_cast<double>(d.contribution_entries)), largest);
    const double beside = entries - p * pivots;
    b = std::min(beside > 0 ? d.flops.gemm / beside : largest, largest - p);
  }
  return {p, b};
}

double equivalent_size(const DepthSummary& depth) {
  const FrontShape front = mean_front(depth);
  return equivalent_size(front.pivots, front.border);
}

Prediction predict(const MachineRates& rates, const Report& report, const std::vector<DepthSummary>& depths) {
  const auto entries = static_cast<double>(report.nnz), rows = static_cast<double>(report.n);
  const bool on_device = backend_info(report.backend).memory == MemorySpace::device;
  Prediction sum{
      rates.refactor_call + entries * rates.refactor_seconds_per_entry,
      rates.solve_call + entries * rates.solve_seconds_per_entry + rows * rates.solve_seconds_per_row,
      rates.date};
  for (const DepthSummary& depth : depths) {
    const double size = clamped(equivalent_size(depth), rates);
    sum.refactor += time_of(interpolated(rates.fronts, &FrontRate::refactor, size),
                            depth.flops.total() / flops_of_front(size));
    const auto factors = static_cast<double>(depth.factor_entries);
    sum.solve += on_device ? device_solve(rates, mean_front(depth), factors)
                           : time_of(interpolated(rates.fronts, &FrontRate::solve, size),
                                     factors / entries_of_front(size));
  }
  if (report.partial) {
    const auto moving = [&](std::int64_t bytes) {
      return static_cast<double>(bytes) / rates.link_bytes_per_second;
    };
    sum.refactor = std::max(report.slowdown * sum.refactor, moving(report.bytes_out));
    sum.solve += moving(report.bytes_back);
  }
  return sum;
}

RatesKey rates_key(Backend backend, int threads) {
  const bool on_device = backend_info(backend).memory == MemorySpace::device && !devices().empty();
  return {on_device ? devices().front().name : host_processor(), library_version("BLAS"),
          backend_name(backend), threads};
}

std::string rates_path() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && cache[0] == '/') return std::string(cache) + "/mfs/rates.json";
  const char* home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') return std::string(home) + "/.cache/mfs/rates.json";
  return "";
}

RatesFile read_rates(const std::string& path) {
  RatesFile found;
  std::ifstream file(path, std::ios::binary);
  if (path.empty() || !file) return found;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  try {
    const Json json = Json::parse(text);
    if (json.at("format") != kFormat) throw std::domain_error("another format");
    for (const Json& rates : json.at("rates")) found.rates.push_back(from_json(rates));
  } catch (const std::exception&) {
    found.rates.clear();
    found.damaged = true;
  }
  return found;
}

void make_rates_folder(const std::string& path) {
  if (path.empty()) throw InvalidInput("XDG_CACHE_HOME", "neither it nor HOME names a folder for the rates");
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (error) throw InvalidInput(path, "the folder cannot be made: " + error.message());
  io::check_writable(path);
}

void keep_rates(const std::string& path, const MachineRates& rates) {
  make_rates_folder(path);
  std::vector<MachineRates> all = read_rates(path).rates;
  all.erase(
      std::remove_if(all.begin(), all.end(), [&](const MachineRates& old) { return old.key == rates.key; }),
      all.end());
  all.push_back(rates);
  Json json{{"format", kFormat}, {"rates", Json::array()}};
  for (const MachineRates& one : all) json["rates"].push_back(to_json(one));
  io::write_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace mfs::program
