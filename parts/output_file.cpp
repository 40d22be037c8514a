#include "parts/output_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <mfs/error.hpp>

#include "solver/replaced_file.hpp"

namespace mfs::io {

OutputFile::OutputFile(const std::string& path)
    : path_(path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "w")) {
  if (!file_) throw InvalidInput(path_, std::string("cannot be opened for writing: ") + std::strerror(errno));
}

void OutputFile::fail() const {
  throw InvalidInput(path_ == "-" ? "standard output" : path_,
                     std::string("cannot be written: ") + std::strerror(errno));
}

void OutputFile::write(std::string_view text) {
  const bool complete = std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
  if (!complete || std::fflush(file_.get()) != 0) fail();
}

void OutputFile::overwrite(std::size_t position, std::string_view text) {
  if (std::fseek(file_.get(), static_cast<long>(position), SEEK_SET) != 0) fail();
  write(text);
  if (std::fseek(file_.get(), 0, SEEK_END) != 0) fail();
}

void print(const std::string& text) {
  OutputFile("-").write(text);
}

bool is_stream(const std::string& path) {
  struct stat found {};
  return path == "-" || (stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode));
}

void check_writable(const std::string& path) {
  if (path == "-") return;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const std::string target = access(path.c_str(), F_OK) == 0 ? path : folder.empty() ? "." : folder;
  if (access(target.c_str(), W_OK) != 0)
    throw InvalidInput(path, std::string("cannot be opened for writing: ") + std::strerror(errno));
}

void write_file(const std::string& path, const std::string& text) {
  if (path == "-") return print(text);
  ReplacedFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace mfs::io
