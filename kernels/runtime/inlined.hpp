// MFS_INLINE: a function that becomes part of those that call it, and so is compiled for their processor.
#pragma once

#define MFS_INLINE inline __attribute__((always_inline))
