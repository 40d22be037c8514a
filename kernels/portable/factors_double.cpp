#include "kernels/portable/portable_factors_def.hpp"

namespace mfs::portable {

MFS_INSTANTIATE_PORTABLE(double, double)

}  // namespace mfs::portable
