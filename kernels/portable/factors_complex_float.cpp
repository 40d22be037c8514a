#include "kernels/portable/portable_factors_def.hpp"

namespace mfs::portable {

MFS_INSTANTIATE_PORTABLE(std::complex<float>, std::complex<float>)

}  // namespace mfs::portable
