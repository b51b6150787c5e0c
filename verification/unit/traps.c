/* Of run_unit_tests-checked (cmake/checked.cmake): invalid operations, division by zero and overflow end it, from before its main program on. */
#define _GNU_SOURCE
#include <fenv.h>

__attribute__((constructor)) static void trap(void) {
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
}
