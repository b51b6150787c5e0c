# What a Python wheel holds beside the packages of tools/: the shared library inside the package, the program and its
# helpers, as programs of the environment.
install(FILES $<TARGET_FILE:qsmpm_shared> DESTINATION qsmpm RENAME libqsmpm.so)
install(PROGRAMS $<TARGET_FILE:qsmpm_program> DESTINATION ${SKBUILD_SCRIPTS_DIR})
include(${CMAKE_CURRENT_LIST_DIR}/wheel_helpers.cmake)
