!> Terms of a step by name, forces of one or all of them, and their matrix against differences, for tests.
module term_samples
  use qsmpm_contacts, only: contacts_type
  use qsmpm_equations, only: gather
  use qsmpm_initialisation, only: step_type, evaluate_step
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: tangent_none, tangent_consistent
  use qsmpm_model, only: model_type
  use qsmpm_sparse_matrix, only: multiply
  use qsmpm_term, only: term_type, increment_type, role_external
  use qsmpm_term_share, only: solve_share_type, step_share_type, add_solves, share_named
  use qsmpm_term_sums, only: add_all_blocks, begin_terms, set_loads, sum_forces
  implicit none
  private

  public :: term_named, contacts_of, force_named, load_at, damp, share_of, matrix_and_difference, waves

contains

  !> Displacements and pressures without order, of the size of a hundredth.
  function waves(step, phase) result(table)
    type(step_type), intent(in) :: step
    real(wp), intent(in) :: phase
    real(wp) :: table(size(step%equations%constrained, 1), size(step%equations%constrained, 2))
    integer :: a

    do a = 1, size(table, 2)
      table(:2, a) = 0.01_wp*[sin(1.7_wp*a + phase), cos(2.3_wp*a + phase)]
      table(3:, a) = 0.01_wp*sin(3.1_wp*a + phase)
    end do
  end function waves

  !> The term of a name.
  function term_named(step, name) result(term)
    type(step_type), intent(in), target :: step
    character(len=*), intent(in) :: name
    class(term_type), pointer :: term
    integer :: t

    term => null()
    do t = 1, size(step%terms)
      if (step%terms(t)%term%name == name) term => step%terms(t)%term
    end do
    if (.not. associated(term)) error stop 'a test asks for a term that is not there'
  end function term_named

  !> The term of contact.
  function contacts_of(step) result(contacts)
    type(step_type), intent(in) :: step
    type(contacts_type) :: contacts
    integer :: t

    do t = 1, size(step%terms)
      select type (term => step%terms(t)%term)
      type is (contacts_type)
        contacts = term
      end select
    end do
  end function contacts_of

  !> Its force at a displacement.
  function force_named(step, name, displacement) result(force)
    type(step_type), intent(in), target :: step
    character(len=*), intent(in) :: name
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: force(size(displacement, 1), size(displacement, 2))
    class(term_type), pointer :: term

    force = 0.0_wp
    term => term_named(step, name)
    call term%add_force(displacement, force)
  end function force_named

  !> Put the loads of a fraction of the phase in force; what they are without a displacement.
  subroutine load_at(model, step, fraction, load)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: fraction
    !> (components, nodes)
    real(wp), intent(out) :: load(:, :)
    real(wp) :: still(size(load, 1), size(load, 2))

    still = 0.0_wp
    call set_loads(step%terms, model, step%configuration_type, fraction)
    call sum_forces(step%terms, role_external, still, load)
  end subroutine load_at

  !> Damp the step.
  subroutine damp(step, coefficient)
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: coefficient

    call begin_terms(step%terms, increment_type(damping=coefficient))
  end subroutine damp

  !> The matrix times a direction, and the change of the resistance along it by central differences.
  subroutine matrix_and_difference(model, step, displacement, along, difference, product, change)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :), along(:, :)
    !> Step of the differences.
    real(wp), intent(in) :: difference
    !> (equations)
    real(wp), allocatable, intent(out) :: product(:), change(:)
    real(wp) :: direction(size(along, 1), size(along, 2)), x(step%equations%count), ahead(step%equations%count), &
      back(step%equations%count)

    direction = merge(0.0_wp, along, step%equations%constrained)
    allocate (product(step%equations%count), change(step%equations%count))
    call gather(step%equations, direction, x)
    call evaluate_step(model, step, displacement, tangent_consistent)
    call add_all_blocks(step%terms, displacement, step%equations, step%matrix)
    call multiply(step%matrix, x, product)
    call find_resistance(displacement + difference*direction, ahead)
    call find_resistance(displacement - difference*direction, back)
    change = (ahead - back)/(2.0_wp*difference)
  contains
    !> Minus the residual.
    subroutine find_resistance(at, vector)
      real(wp), intent(in) :: at(:, :)
      real(wp), intent(out) :: vector(:)

      call evaluate_step(model, step, at, tangent_none)
      call gather(step%equations, step%forces%internal + step%forces%numerical - step%forces%external, vector)
    end subroutine find_resistance
  end subroutine matrix_and_difference

  !> Share of a name after one solve.
  real(wp) function share_of(solve, name)
    type(solve_share_type), intent(in) :: solve(:)
    character(len=*), intent(in) :: name
    type(step_share_type), allocatable :: step(:)

    call add_solves(solve, step)
    share_of = share_named(step, name)
  end function share_of
end module term_samples
