#include "solver/program/output_file.hpp"

#include <cerrno>
#include <cstring>

#include <mfs/error.hpp>

namespace mfs::io {

OutputFile::OutputFile(const std::string& path)
    : path_(path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "w")) {
  if (!file_) throw InvalidInput(path_, std::string("cannot be opened for writing: ") + std::strerror(errno));
}

void OutputFile::write(const std::string& text) {
  const bool complete = std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
  if (!complete || std::fflush(file_.get()) != 0)
    throw InvalidInput(path_ == "-" ? "standard output" : path_,
                       std::string("cannot be written: ") + std::strerror(errno));
}

void print(const std::string& text) {
  OutputFile("-").write(text);
}

}  // namespace mfs::io
