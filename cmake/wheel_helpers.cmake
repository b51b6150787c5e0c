# Scripts of a wheel, and what they look for.
install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/build-umat ${PROJECT_SOURCE_DIR}/tools/convert-deck
  DESTINATION ${SKBUILD_SCRIPTS_DIR})
install(FILES ${PROJECT_SOURCE_DIR}/tools/umat/ABA_PARAM.INC ${PROJECT_SOURCE_DIR}/tools/umat/aba_param.inc
  ${PROJECT_SOURCE_DIR}/src/materials/user/umat_helpers.c DESTINATION ${SKBUILD_DATA_DIR}/share/qsmpm/umat)
