# Sequential MUMPS, double and single precision: target MUMPS::seq. Debian: libmumps-seq-dev, which brings no
# CMake or pkg-config file.
#
# MUMPSSeq_INCLUDE_DIR holds dmumps_struc.h, a Fortran include file. It stands in the system's
# include folder, where gfortran does not look and which CMake leaves out of the command line
# (CMAKE_Fortran_IMPLICIT_INCLUDE_DIRECTORIES): the one source that includes it gets the folder as
# a compile option (CMakeLists.txt), and MUMPS::seq carries no include folder.
find_path(MUMPSSeq_INCLUDE_DIR dmumps_struc.h)
set(_MUMPSSeq_variables MUMPSSeq_INCLUDE_DIR)
foreach(name dmumps_seq smumps_seq mumps_common_seq pord_seq mpiseq_seq)
  find_library(MUMPSSeq_${name}_LIBRARY ${name})
  list(APPEND _MUMPSSeq_variables MUMPSSeq_${name}_LIBRARY)
endforeach()
mark_as_advanced(${_MUMPSSeq_variables})

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(MUMPSSeq REQUIRED_VARS ${_MUMPSSeq_variables})

if(MUMPSSeq_FOUND AND NOT TARGET MUMPS::seq)
  add_library(MUMPS::seq UNKNOWN IMPORTED)
  set_target_properties(MUMPS::seq PROPERTIES
    IMPORTED_LOCATION "${MUMPSSeq_dmumps_seq_LIBRARY}"
    INTERFACE_LINK_LIBRARIES
      "${MUMPSSeq_smumps_seq_LIBRARY};${MUMPSSeq_mumps_common_seq_LIBRARY};${MUMPSSeq_pord_seq_LIBRARY};${MUMPSSeq_mpiseq_seq_LIBRARY}")
endif()
unset(_MUMPSSeq_variables)
