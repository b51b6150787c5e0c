# The program qsmpm-checked and the unit tests run_unit_tests-checked: what is compiled without the checks of a debug build beside them,
# the files where time goes, is compiled once more with them and comes before the library, from which the linker takes the rest.
add_library(qsmpm_checked OBJECT ${timed_sources})
set_target_properties(qsmpm_checked PROPERTIES Fortran_MODULE_DIRECTORY ${PROJECT_BINARY_DIR}/modules_checked)
target_compile_options(qsmpm_checked PRIVATE "$<$<COMPILE_LANGUAGE:Fortran>:${debug_flags}>")
target_link_libraries(qsmpm_checked PRIVATE qsmpm_flags ${libraries} PUBLIC qsmpm)

get_target_property(sources qsmpm_program SOURCES)
get_target_property(options qsmpm_program LINK_OPTIONS)
add_executable(qsmpm_program_checked ${sources})
set_target_properties(qsmpm_program_checked PROPERTIES OUTPUT_NAME qsmpm-checked RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
target_compile_options(qsmpm_program_checked PRIVATE "$<$<COMPILE_LANGUAGE:Fortran>:${debug_flags}>")
target_link_options(qsmpm_program_checked PRIVATE ${options})
target_link_libraries(qsmpm_program_checked PRIVATE qsmpm_checked qsmpm_flags)

# What a main program compiled with -ffpe-trap switches on, traps.c does here.
add_executable(run_unit_tests-checked $<TARGET_OBJECTS:run_unit_tests> verification/unit/traps.c)
set_target_properties(run_unit_tests-checked PROPERTIES LINKER_LANGUAGE Fortran RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
target_link_libraries(run_unit_tests-checked PRIVATE qsmpm_checked qsmpm_flags)
add_dependencies(run_unit_tests-checked plugins)
