!> Out-of-balance of a step with one field or several (eq. 27): the residual of each relative to a reference of its own
!> and to the tolerance of its own, so that none hides behind the numbers of another's units. The largest one decides.
!>
!> The reference is the norm of the load, in any field the external contributions at the free components; with
!> prescribed values, or without load, at least that of the reactions; beside the displacement also that of the
!> contributions of the terms by their size (`add_sizes`): what flows in a closed body has neither load nor reaction.
module qsmpm_field_balance
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, joint_norm
  use qsmpm_equations, only: gather
  use qsmpm_finite, only: is_usable
  use qsmpm_initialisation, only: step_type
  use qsmpm_nodal_fields, only: add_shares
  use qsmpm_term_sums, only: sum_field_sizes
  use qsmpm_unknowns, only: joint_node
  implicit none
  private

  public :: find_references, find_imbalance

contains

  !> Reference of every field at the last evaluation.
  subroutine find_references(step, prescribed, least_load, reference)
    type(step_type), intent(in) :: step
    !> Prescribed changes (components, nodes).
    real(wp), intent(in) :: prescribed(:, :)
    !> Norm of the load at the least.
    real(wp), intent(in) :: least_load
    !> (fields)
    real(wp), intent(out) :: reference(:)
    real(wp) :: load(step%equations%count)
    real(wp), allocatable :: sizes(:, :)
    integer :: f, first, last
    logical :: pushed

    call gather(step%equations, step%forces%external, load)
    if (size(reference) > 1) then
      allocate (sizes, mold=prescribed)
      call sum_field_sizes(step%terms, sizes)
      call add_shares(step%team, step%unknowns, sizes)
      if (step%team%rank > 0) sizes = 0.0_wp
    end if
    do f = 1, size(reference)
      reference(f) = joint_norm(step%team, norm2(pack(load, step%field_of == f)))
      if (f == 1) reference(f) = max(reference(f), least_load)
      first = joint_node(step%unknowns, 1, f)
      last = joint_node(step%unknowns, step%unknowns%fields(f)%node_count, f)
      if (f > 1) reference(f) = max(reference(f), joint_norm(step%team, norm2(sizes(:, first:last))))
      pushed = any_of(step%team, any(abs(prescribed(:, first:last)) > 0.0_wp))
      if (pushed .or. reference(f) <= 0.0_wp) reference(f) = max(reference(f), joint_norm(step%team, &
        norm2(pack(step%forces%internal(:, first:last), step%equations%constrained(:, first:last) .and. &
        spread(step%equations%active(first:last) .and. step%own(first:last), 1, size(prescribed, 1))))))
    end do
  end subroutine find_references

  !> The largest relative residual of the fields, in parts of what the forces are allowed, and which field has it.
  subroutine find_imbalance(step, residual, reference, ratio, field)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: residual(:)
    !> (fields)
    real(wp), intent(in) :: reference(:)
    real(wp), intent(out) :: ratio
    integer, intent(out) :: field
    real(wp) :: ratios(size(reference))
    integer :: f

    do f = 1, size(reference)
      ratios(f) = relative(joint_norm(step%team, norm2(pack(residual, step%field_of == f))), reference(f))
      if (ratios(f) < huge(1.0_wp)) ratios(f) = ratios(f)/step%unknowns%fields(f)%tolerance_ratio
    end do
    field = maxloc(ratios, dim=1)
    ratio = ratios(field)
  end subroutine find_imbalance

  !> A norm relative to its reference; without any everything must vanish. What is not a number is as large as can be.
  pure real(wp) function relative(norm, reference) result(ratio)
    real(wp), intent(in) :: norm, reference

    ratio = huge(1.0_wp)
    if (.not. (is_usable(norm) .and. is_usable(reference))) return
    if (norm <= 0.0_wp) ratio = 0.0_wp
    if (norm <= reference*sqrt(huge(1.0_wp)) .and. reference > 0.0_wp) ratio = norm/reference
  end function relative
end module qsmpm_field_balance
