!> PETSc in a program without it: every call fails and its message names the program that has it.
submodule (qsmpm_petsc_solver) petsc_absent
  use qsmpm_error, only: fail, error_other
  implicit none

  character(len=*), parameter :: reason = &
    'this program has no PETSc; build qsmpm-mpi (cmake -DQSMPM_MPI=ON, docs/distributed.md) or choose another solver'

contains

  module procedure with_petsc
    has = .false.
  end procedure with_petsc

  module procedure analyse_pattern
    call fail(error, error_other, reason)
  end procedure analyse_pattern

  module procedure factorise_values
    call self%analyse_pattern(matrix, error)
  end procedure factorise_values

  module procedure solve_factorised
    x = 0.0_wp
    call fail(error, error_other, reason)
  end procedure solve_factorised

  module procedure forget
  end procedure forget

  module procedure release
  end procedure release
end submodule petsc_absent
