# Writes the names of the libraries of CUDA that LIBRARY needs to OUTPUT, one a line; READELF is the program.
execute_process(COMMAND ${READELF} -d ${LIBRARY} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\\[lib(cu|nv)[^]]*\\]" names "${dynamic}")
list(TRANSFORM names REPLACE "[][]" "")
list(JOIN names "\n" lines)
file(WRITE ${OUTPUT} "${lines}\n")
