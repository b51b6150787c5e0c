# CHOLMOD and UMFPACK: targets SuiteSparse::cholmod and SuiteSparse::umfpack.
# Debian: libsuitesparse-dev, which brings no CMake or pkg-config file. Both are under the
# GPL (docs/licences.md).
find_path(SuiteSparse_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(SuiteSparse_cholmod_LIBRARY cholmod)
find_library(SuiteSparse_umfpack_LIBRARY umfpack)
mark_as_advanced(SuiteSparse_INCLUDE_DIR SuiteSparse_cholmod_LIBRARY SuiteSparse_umfpack_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SuiteSparse
  REQUIRED_VARS SuiteSparse_cholmod_LIBRARY SuiteSparse_umfpack_LIBRARY SuiteSparse_INCLUDE_DIR)

if(SuiteSparse_FOUND)
  foreach(name cholmod umfpack)
    if(NOT TARGET SuiteSparse::${name})
      add_library(SuiteSparse::${name} UNKNOWN IMPORTED)
      set_target_properties(SuiteSparse::${name} PROPERTIES
        IMPORTED_LOCATION "${SuiteSparse_${name}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${SuiteSparse_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
