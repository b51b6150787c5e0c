# Installation: program, libraries, modules of this compiler, header, interface sources for other compilers, CMake
# package, pkg-config file; documents and licences are left to install_docs.cmake.
if(SKBUILD)
  include(${CMAKE_CURRENT_LIST_DIR}/wheel.cmake)
  return()
endif()
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/qsmpm)
set(source_dir ${CMAKE_INSTALL_DATADIR}/qsmpm/fortran)

if(QSMPM_PROGRAM)
  install(TARGETS qsmpm_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
# Asked for by name, and in no package: PETSc brings the licences of what it is linked with (docs/licences.md).
if(QSMPM_MPI)
  install(TARGETS qsmpm-mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mpi EXCLUDE_FROM_ALL)
endif()
# Builds soil models of the user's own: the script, and what it looks for under share/qsmpm/umat.
install(PROGRAMS tools/build-umat tools/convert-deck DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES tools/umat/ABA_PARAM.INC tools/umat/aba_param.inc src/materials/user/umat_helpers.c
  DESTINATION ${CMAKE_INSTALL_DATADIR}/qsmpm/umat)
install(TARGETS qsmpm EXPORT qsmpm_targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT qsmpm_targets FILE qsmpmTargets.cmake NAMESPACE qsmpm:: DESTINATION ${package_dir})
if(TARGET qsmpm_shared)
  install(TARGETS qsmpm_shared EXPORT qsmpm_shared_targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT qsmpm_shared_targets FILE qsmpmSharedTargets.cmake NAMESPACE qsmpm:: DESTINATION ${package_dir})
endif()
install(DIRECTORY ${PROJECT_BINARY_DIR}/modules/ DESTINATION ${modules_dir} FILES_MATCHING PATTERN "*.mod")
install(FILES src/api/include/qsmpm.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES src/api/include/qsmpm_c.f90 src/api/include/qsmpm_f77.f90 DESTINATION ${source_dir})
include(${CMAKE_CURRENT_LIST_DIR}/install_docs.cmake)

configure_package_config_file(cmake/qsmpmConfig.cmake.in ${PROJECT_BINARY_DIR}/generated/qsmpmConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS source_dir)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/qsmpmConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/generated/qsmpmConfig.cmake ${PROJECT_BINARY_DIR}/generated/qsmpmConfigVersion.cmake
  cmake/FindMETIS.cmake cmake/FindMUMPSSeq.cmake cmake/FindSuiteSparse.cmake DESTINATION ${package_dir})

# What a program that links the static library with another linker than CMake's needs.
set(private ${HDF5_Fortran_LIBRARIES} ${MUMPSSeq_dmumps_seq_LIBRARY} ${MUMPSSeq_smumps_seq_LIBRARY}
  ${MUMPSSeq_mumps_common_seq_LIBRARY} ${MUMPSSeq_pord_seq_LIBRARY} ${MUMPSSeq_mpiseq_seq_LIBRARY})
if(QSMPM_WITH_SUITESPARSE)
  list(APPEND private ${SuiteSparse_umfpack_LIBRARY} ${SuiteSparse_cholmod_LIBRARY})
endif()
list(APPEND private ${METIS_LIBRARY} ${LAPACK_LIBRARIES} ${OpenMP_Fortran_LIBRARIES} ${CMAKE_DL_LIBS})
foreach(library ${CMAKE_Fortran_IMPLICIT_LINK_LIBRARIES})
  if(NOT library MATCHES "^(c|gcc|gcc_s)$")
    list(APPEND private ${library})
  endif()
endforeach()
list(REMOVE_DUPLICATES private)
set(private_flags "")
foreach(library ${private})
  if(IS_ABSOLUTE "${library}" OR library MATCHES "^-")
    string(APPEND private_flags " ${library}")
  else()
    string(APPEND private_flags " -l${library}")
  endif()
endforeach()
file(RELATIVE_PATH prefix_from_here /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" prefix_from_here "${prefix_from_here}")
configure_file(cmake/qsmpm.pc.in ${PROJECT_BINARY_DIR}/generated/qsmpm.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/generated/qsmpm.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
