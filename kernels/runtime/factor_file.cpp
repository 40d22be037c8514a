#include "kernels/runtime/factor_file.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include <mfs/error.hpp>

namespace mfs {

namespace {

constexpr Offset kBlockBytes = Offset(4) << 20;
constexpr Offset kPage = 4096;  // extents begin at multiples of it

/// Every change of one word changes it: each step is one to one in the word and in what came before.
std::uint64_t checksum(const char* data, Offset bytes) {
  constexpr int kLanes = 8;
  constexpr Offset kWord = sizeof(std::uint64_t), kStride = kLanes * kWord;
  constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15;  // odd
  const auto mixed = [](std::uint64_t sum, std::uint64_t word) {
    sum = (sum ^ word) * kFactor;
    return sum ^ (sum >> 32);
  };
  std::uint64_t lanes[kLanes] = {1, 2, 3, 4, 5, 6, 7, 8};
  for (; bytes >= kStride; bytes -= kStride, data += kStride) {
    std::uint64_t words[kLanes];
    std::memcpy(words, data, sizeof words);
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] = mixed(lanes[lane], words[lane]);
  }
  std::uint64_t sum = static_cast<std::uint64_t>(bytes);
  for (; bytes > 0; bytes -= kWord, data += kWord) {
    std::uint64_t word = 0;
    std::memcpy(&word, data, static_cast<std::size_t>(std::min(bytes, kWord)));
    sum = mixed(sum, word);
  }
  for (const std::uint64_t lane : lanes) sum = mixed(sum, lane);
  return sum;
}

/// Calls `call` again where a signal has interrupted it.
template <class Call>
auto uninterrupted(const Call& call) {
  for (;;) {
    const auto result = call();
    if (result >= 0 || errno != EINTR) return result;
  }
}

}  // namespace

FactorFile::FactorFile(const std::string& folder, const std::vector<Offset>& extents)
    : name_("the factor file in " + folder) {
  Offset at = 0;
  first_block_.push_back(0);
  for (const Offset bytes : extents) {
    for (Offset begin = 0; begin < bytes; begin += kBlockBytes)
      blocks_.push_back({at + begin, std::min(kBlockBytes, bytes - begin), 0});
    first_block_.push_back(blocks_.size());
    at += (bytes + kPage - 1) / kPage * kPage;
  }
  open_in(folder);
  try {
    reserve(at);
  } catch (...) {
    close(file_);
    throw;
  }
}

FactorFile::~FactorFile() {
  close(file_);
}

// Where the file system makes no files without a name, the name goes at once.
void FactorFile::open_in(const std::string& folder) {
  file_ = uninterrupted([&] { return open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); });
  if (file_ >= 0) return;
  if (errno != EOPNOTSUPP && errno != EISDIR) fail(errno, "cannot be made");
  std::string path = folder + "/mfs-XXXXXX";
  file_ = mkostemp(path.data(), O_CLOEXEC);
  if (file_ < 0) fail(errno, "cannot be made");
  unlink(path.c_str());
}

// So a full disk is known before any work is done. A limit on the size of files would end the process by a
// signal.
void FactorFile::reserve(Offset bytes) const {
  rlimit most{};
  if (getrlimit(RLIMIT_FSIZE, &most) == 0 && most.rlim_cur != RLIM_INFINITY &&
      static_cast<rlim_t>(bytes) > most.rlim_cur)
    fail(EFBIG, "cannot have " + std::to_string(bytes) + " bytes");
  if (bytes == 0) return;
  if (uninterrupted([&] { return fallocate(file_, 0, 0, bytes); }) == 0) return;
  if (errno != EOPNOTSUPP && errno != ENOSYS) fail(errno, "cannot have " + std::to_string(bytes) + " bytes");
}

// What one of two processes wrote would be wrong for the other.
void FactorFile::check_process() const {
  if (getpid() != process_)
    throw StateError(name_ + " is that of the process that this one was forked from: make a solver here");
}

void FactorFile::write(std::size_t extent, const char* data) {
  check_process();
  for (std::size_t i = first_block_[extent]; i < first_block_[extent + 1]; ++i) {
    Block& block = blocks_[i];
    block.sum = checksum(data, block.bytes);
    for (Offset done = 0; done < block.bytes;) {
      const ssize_t count = uninterrupted([&] {
        return pwrite(file_, data + done, static_cast<std::size_t>(block.bytes - done), block.at + done);
      });
      if (count <= 0) fail_at(count < 0 ? errno : ENOSPC, "cannot be written", block);
      done += count;
    }
    data += block.bytes;
  }
}

void FactorFile::read(std::size_t extent, char* data) {
  check_process();
  for (std::size_t i = first_block_[extent]; i < first_block_[extent + 1]; ++i) {
    const Block& block = blocks_[i];
    for (Offset done = 0; done < block.bytes;) {
      const ssize_t count = uninterrupted([&] {
        return pread(file_, data + done, static_cast<std::size_t>(block.bytes - done), block.at + done);
      });
      if (count < 0) fail_at(errno, "cannot be read", block);
      if (count == 0) fail_at(EBADMSG, "is not there any more", block);
      done += count;
    }
    if (checksum(data, block.bytes) != block.sum) fail_at(EBADMSG, "is not what was written", block);
    data += block.bytes;
  }
}

void FactorFile::fail(int error, const std::string& what) const {
  throw BackendError("file", error, name_ + " " + what + ": " + std::generic_category().message(error));
}

void FactorFile::fail_at(int error, const char* what, const Block& block) const {
  const auto number = &block - blocks_.data();
  fail(error, "has a block " + std::to_string(number) + " of " + std::to_string(block.bytes) + " bytes at " +
                  std::to_string(block.at) + " that " + what);
}

}  // namespace mfs
