// A file for factors that memory has no room for. It has no name, so nothing is left of it when the process
// ends, however that happens. Its bytes are written and read in extents, each whole; an extent is divided
// into blocks, and a checksum of each block is kept in memory, so that no block is taken for what was written
// unless it is.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ordering/types.hpp"

namespace mfs {

class FactorFile {
 public:
  /// A file in `folder` with room for extents of so many bytes, which the file system is asked to reserve.
  /// Throws BackendError("file") with the system's error number, as write and read do.
  FactorFile(const std::string& folder, const std::vector<Offset>& extents);
  ~FactorFile();
  FactorFile(const FactorFile&) = delete;
  FactorFile& operator=(const FactorFile&) = delete;

  /// The error names the file and the block, counted through all extents. Both throw StateError in a process
  /// that was forked from the file's.
  void write(std::size_t extent, const char* data);
  /// Of an extent that was written. EBADMSG: a block is not what was written.
  void read(std::size_t extent, char* data);

 private:
  struct Block {
    Offset at, bytes;  // in the file
    std::uint64_t sum;
  };
  void open_in(const std::string& folder);
  void reserve(Offset bytes) const;
  void check_process() const;
  [[noreturn]] void fail(int error, const std::string& what) const;
  [[noreturn]] void fail_at(int error, const char* what, const Block& block) const;

  std::string name_;  // for errors
  const pid_t process_ = getpid();
  int file_ = -1;
  std::vector<Block> blocks_;
  std::vector<std::size_t> first_block_;  // by extent, and one more
};

}  // namespace mfs
