# A wheel of what has been built before.
file(REAL_PATH ${QSMPM_BUILT}/libqsmpm.so library)
install(FILES ${library} DESTINATION qsmpm RENAME libqsmpm.so)
install(PROGRAMS ${QSMPM_BUILT}/qsmpm DESTINATION ${SKBUILD_SCRIPTS_DIR})
include(${CMAKE_CURRENT_LIST_DIR}/wheel_helpers.cmake)
