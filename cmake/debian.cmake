# A Debian package of what is installed: `cpack --config build/CPackConfig.cmake -B build`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME qsmpm)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_CONTACT "The QSMPM authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# What the binaries are linked with, by dpkg-shlibdeps; own models and the static library want more.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "gfortran, libhdf5-dev, libmumps-seq-dev, libmetis-dev, libopenblas-dev, libsuitesparse-dev, paraview")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Soil that fails, flows and comes to rest, in equilibrium at every step.
 The program qsmpm, its library for Fortran, C and Fortran 77 with header and interface sources, examples
 and documents. Licences of what is linked are in /usr/share/doc/qsmpm/licences.")
include(CPack)
