# Sparse matrix, ordering and linear solvers of src/solver.
include_guard(GLOBAL)
set(linear_dir ${CMAKE_CURRENT_LIST_DIR})

if(QSMPM_WITH_SUITESPARSE)
  set(suitesparse_sources
    ${linear_dir}/cholmod_shim.c ${linear_dir}/cholmod_solver.f90 ${linear_dir}/umfpack_solver.f90)
else()
  set(suitesparse_sources
    ${linear_dir}/no_suitesparse/cholmod_solver.f90 ${linear_dir}/no_suitesparse/umfpack_solver.f90)
endif()

target_sources(qsmpm PRIVATE
  ${linear_dir}/sparse_matrix.f90
  ${linear_dir}/metis_shim.c
  ${linear_dir}/node_ordering.f90
  ${linear_dir}/blas_threads.f90
  ${linear_dir}/linear_solver.f90
  ${linear_dir}/band_solver.f90
  ${linear_dir}/mumps_library.f90
  ${linear_dir}/mumps_solver.f90
  ${linear_dir}/single_solver.f90
  ${linear_dir}/incomplete_solver.f90
  ${linear_dir}/krylov.f90
  ${suitesparse_sources}
  ${linear_dir}/solver_choice.f90
  ${linear_dir}/linear_system.f90)

# See cmake/FindMUMPSSeq.cmake.
set_source_files_properties(${linear_dir}/mumps_library.f90 TARGET_DIRECTORY qsmpm
  PROPERTIES COMPILE_OPTIONS "-I${MUMPSSeq_INCLUDE_DIR}")

# Timing of the solvers (docs/performance.md): built only when asked for.
if(QSMPM_UNIT_TESTS)
  add_executable(bench_solvers EXCLUDE_FROM_ALL
    ${linear_dir}/../../verification/unit/deck_matrices.f90
    ${linear_dir}/../../tools/bench_solvers.f90)
  set_target_properties(bench_solvers PROPERTIES
    Fortran_MODULE_DIRECTORY ${PROJECT_BINARY_DIR}/bench_modules
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  target_link_libraries(bench_solvers PRIVATE qsmpm)
endif()
