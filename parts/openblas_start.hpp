// What has to be done before OpenBLAS is there.
//
// Its constructor takes a buffer of address space for each of its threads, in newer versions for the caller,
// too. Where there is no room it asks again without end (0.3.29) or ends the process (0.3.34). Nothing of
// main's runs that early, but functions in .preinit_array do: the loader calls those of a program when all
// libraries are mapped and bound and none has been started; of the C library the environment is not there
// yet.
#pragma once

namespace mfs::program {

/// For .preinit_array. With a limit of the address space OpenBLAS gets no threads of its own, which MFS does
/// not use; where not even one buffer finds room, the process ends with ExitCode::out_of_memory and a
/// message.
void prepare_openblas(int argc, char** argv, char** environment);

}  // namespace mfs::program
