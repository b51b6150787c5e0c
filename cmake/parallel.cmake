# The program qsmpm-mpi: the objects of `qsmpm` and of its library, but for those that are of one process alone
# (src/parallel/alone, src/solver/no_petsc), in whose place come those that use MPI and PETSc. Nothing else is compiled,
# and the sequential MUMPS with its empty MPI must not be linked beside the real ones.
if(NOT TARGET qsmpm_program)
  message(FATAL_ERROR "QSMPM_MPI=ON builds a program: it wants QSMPM_PROGRAM=ON")
endif()
find_package(MPI REQUIRED COMPONENTS C Fortran)
find_package(PkgConfig REQUIRED)
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET petsc)
foreach(name dmumps smumps)
  find_library(MUMPS_${name}_LIBRARY ${name} REQUIRED)
  mark_as_advanced(MUMPS_${name}_LIBRARY)
endforeach()

file(GLOB parallel_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/parallel/mpi/*.f90 ${PROJECT_SOURCE_DIR}/src/solver/petsc/*.f90
  ${PROJECT_SOURCE_DIR}/src/solver/petsc/*.c)
add_library(qsmpm_parallel OBJECT ${parallel_sources})
set_target_properties(qsmpm_parallel PROPERTIES Fortran_MODULE_DIRECTORY ${PROJECT_BINARY_DIR}/modules)
target_include_directories(qsmpm_parallel SYSTEM PRIVATE ${PETSC_INCLUDE_DIRS})
target_link_libraries(qsmpm_parallel PRIVATE qsmpm qsmpm_flags MPI::MPI_C MPI::MPI_Fortran)

set(parallel_libraries ${libraries})
list(REMOVE_ITEM parallel_libraries MUMPS::seq)
list(APPEND parallel_libraries PkgConfig::PETSC ${MUMPS_dmumps_LIBRARY} ${MUMPS_smumps_LIBRARY} MPI::MPI_Fortran MPI::MPI_C)

# parallel_program(NAME PROGRAM): what PROGRAM is with one process, NAME is with many.
function(parallel_program name program)
  add_executable(${name} $<TARGET_OBJECTS:${program}> $<TARGET_OBJECTS:qsmpm_parallel>
    $<FILTER:$<TARGET_OBJECTS:qsmpm>,EXCLUDE,/parallel/alone/|/solver/no_petsc/>)
  set_target_properties(${name} PROPERTIES LINKER_LANGUAGE Fortran RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  target_link_libraries(${name} PRIVATE ${parallel_libraries})
  get_target_property(options ${program} LINK_OPTIONS)
  if(options)
    target_link_options(${name} PRIVATE ${options})
  endif()
endfunction()
parallel_program(qsmpm-mpi qsmpm_program)
