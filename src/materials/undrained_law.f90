!> A law of effective stress with pore water that cannot drain: undrained soil.
!>
!> With the excess pore pressure p, positive in compression, K = K_w/n and J = det F of the step
!>   p_end = p - K ln J,   sigma = sigma' - p,   Q = Q' - p_end cof F,   cof F = J F^-T,
!>   A = A' + J (K - p_end) F^-T x F^-T + p_end J (F^-T)_il (F^-T)_kj   for (ij, kl),
!> Q' and A' those of the law for sigma' = sigma + p at the start. K is proportional to the soil's G of the step
!> (nu and nu_u are constant). Sums of ln J do not depend on the steps. p is the
!> last state variable. The stress of points is sigma: the equations of motion do not involve the pore water.
!>
!> In a phase in which the excess pressure dissipates (drainage_dissipates) it decreases with the load fraction,
!>   p_end = p (1 - t_end)/(1 - t_start),
!> independently of the soil, so that stress is transferred step by step from the water to the skeleton, in equilibrium.
module qsmpm_undrained_law
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: law_type, batch_type, step_info_type, status_ok, tangent_none, outer_law_type, &
    unnamed_states
  use qsmpm_tensor, only: determinant, inverse, unpack_gradient, gradient_row, gradient_column, gradient_size
  use qsmpm_text, only: real_text, string_type
  use qsmpm_undrained_parameters, only: undrained_type, water_stiffness, undrained_ratio, undrained_c, drainage_none, &
    drainage_dissipates
  implicit none
  private

  public :: undrained_law_type, make_undrained

  !> Name of the state variable.
  character(len=*), parameter, public :: excess_pressure_name = 'excess_pore_pressure'
  !> Remaining load fraction below which a phase is at its end.
  real(wp), parameter :: end_of_phase = 1.0e-12_wp

  !> The undrained law; the inner law is that of the effective stress.
  type, extends(outer_law_type) :: undrained_law_type
    !> Ratio of K_w/n to G.
    real(wp) :: ratio = 0.0_wp
    !> One of drainage_* of each phase; unallocated: undrained in all phases (phases).
    integer, allocatable :: drainage(:)
  contains
    procedure :: start_at
    procedure :: strengthen
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: effective_stress
    procedure :: shear_modulus
    procedure :: shear_compliance
  end type undrained_law_type

contains

  !> Adds pore water to a law of effective stress; total stress analysis (TYPE=C) has none.
  subroutine make_undrained(undrained, law, error)
    type(undrained_type), intent(in) :: undrained
    class(law_type), allocatable, intent(inout) :: law
    !> Set when the water would have no stiffness.
    type(error_type), allocatable, intent(out) :: error
    type(undrained_law_type), allocatable :: wet
    real(wp) :: poisson

    if (.not. undrained%given .or. undrained%kind == undrained_c) return
    allocate (wet)
    poisson = law%stiffness_scale/(2.0_wp*law%shear_scale) - 1.0_wp
    wet%ratio = water_stiffness(undrained, 1.0_wp, poisson)
    if (.not. wet%ratio > 0.0_wp) then
      call fail(error, error_deck, 'NU='//real_text(undrained_ratio(undrained, poisson))//" of *UNDRAINED is not "// &
        "above Poisson's ratio of the soil, "//real_text(real(nint(poisson*1.0e6_wp), wp)/1.0e6_wp))
      return
    end if
    if (allocated(undrained%drainage)) wet%drainage = undrained%drainage
    wet%law_traits_type = law%law_traits_type
    wet%state_count = law%state_count + 1
    if (.not. allocated(wet%state_names)) wet%state_names = unnamed_states(law%state_count)
    wet%state_names = [wet%state_names, string_type(excess_pressure_name)]
    call move_alloc(law, wet%law)
    call move_alloc(wet, law)
  end subroutine make_undrained

  !> Initialises the state: the given stress is effective, the excess pressure zero.
  subroutine start_at(self, stress, place, state)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), place(3)
    real(wp), intent(out) :: state(:)

    call self%law%start_at(stress, place, state(:self%law%state_count))
    state(self%state_count) = 0.0_wp
  end subroutine start_at

  !> Updates the strength from the effective stress.
  pure subroutine strengthen(self, stress, state)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:)
    real(wp), intent(inout) :: state(:)

    call self%law%strengthen(stress + [spread(state(self%state_count), 1, 3), spread(0.0_wp, 1, size(stress) - 3)], &
      state(:self%law%state_count))
  end subroutine strengthen

  !> Updates a batch: the inner law receives effective stresses, which are then converted to total stresses.
  subroutine update(self, batch, tangent)
    class(undrained_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    integer, intent(in) :: tangent
    real(wp) :: total(size(batch%stress_start, 1), batch%count)
    integer :: p

    total = batch%stress_start(:, :batch%count)
    associate (pressure_start => batch%state_start(self%state_count, :), pressure => batch%state(self%state_count, :))
      do p = 1, batch%count
        batch%stress_start(:3, p) = total(:3, p) + pressure_start(p)
        pressure(p) = pressure_start(p)
      end do
      call self%law%update(batch, tangent)
      do p = 1, batch%count
        if (batch%status(p) == status_ok) call add_water(self, batch, p, tangent)
        batch%stress(:3, p) = batch%stress(:3, p) - pressure(p)
      end do
      batch%stress_start(:, :batch%count) = total
    end associate
  end subroutine update

  !> Computes the excess pressure at the end and adds its part to Q and A; the stress at the start is effective.
  pure subroutine add_water(self, batch, p, tangent)
    class(undrained_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> Number of the point, and requested tangent.
    integer, intent(in) :: p, tangent
    real(wp) :: f(3, 3), back(3, 3), det, stiffness
    integer :: i, j, d

    d = self%dimension
    f = unpack_gradient(batch%gradient(:, p))
    det = determinant(f)
    back = transpose(inverse(f, det))
    stiffness = self%ratio*self%law%shear_modulus(batch%stress_start(:, p), &
      batch%state_start(:self%law%state_count, p))
    call find_pressure(self, batch%step_info, log(det), batch%state_start(self%state_count, p), stiffness, &
      batch%state(self%state_count, p))
    associate (pressure => batch%state(self%state_count, p))
      do i = 1, gradient_size(d)
        batch%piola(i, p) = batch%piola(i, p) - pressure*det*back(gradient_row(i, d), gradient_column(i, d))
      end do
      if (tangent == tangent_none) return
      do j = 1, gradient_size(d)
        do i = 1, gradient_size(d)
          associate (r => gradient_row(i, d), c => gradient_column(i, d), k => gradient_row(j, d), &
            l => gradient_column(j, d))
            batch%tangent(i, j, p) = batch%tangent(i, j, p) + det*((stiffness - pressure)*back(r, c)*back(k, l) &
              + pressure*back(r, l)*back(k, c))
          end associate
        end do
      end do
    end associate
  end subroutine add_water

  !> Computes the excess pressure at the end of a step.
  pure subroutine find_pressure(self, step_info, logarithm, before, stiffness, after)
    class(undrained_law_type), intent(in) :: self
    type(step_info_type), intent(in) :: step_info
    !> ln J of the step, excess pressure at its start.
    real(wp), intent(in) :: logarithm, before
    !> K_w/n; set to zero where the water can drain.
    real(wp), intent(inout) :: stiffness
    real(wp), intent(out) :: after
    real(wp) :: left
    integer :: drainage

    drainage = drainage_none
    if (allocated(self%drainage)) then
      if (step_info%phase <= size(self%drainage)) drainage = self%drainage(step_info%phase)
    end if
    if (drainage /= drainage_none) stiffness = 0.0_wp
    after = before - stiffness*logarithm
    if (drainage /= drainage_dissipates) return
    left = 1.0_wp - step_info%start - step_info%duration
    after = 0.0_wp
    if (left > end_of_phase) after = before*left/(1.0_wp - step_info%start)
  end subroutine find_pressure

  !> Number of fields: those of the inner law, and the excess pressure.
  pure integer function fit_count(self)
    class(undrained_law_type), intent(in) :: self

    fit_count = self%law%fit_count() + 1
  end function fit_count

  !> Converts to fields of the effective stress, and the excess pressure.
  pure subroutine to_fields(self, stress, state, fields)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp), intent(out) :: fields(:)
    integer :: n

    n = self%fit_count()
    call self%law%to_fields(self%effective_stress(stress, state), state(:self%law%state_count), fields(:n - 1))
    fields(n) = state(self%state_count)
  end subroutine to_fields

  !> Converts fields back.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: fields(:), volume_ratio
    real(wp), intent(out) :: stress(:), state(:)
    integer :: n

    n = self%fit_count()
    call self%law%from_fields(fields(:n - 1), volume_ratio, stress, state(:self%law%state_count))
    state(self%state_count) = fields(n)
    stress(:3) = stress(:3) - fields(n)
  end subroutine from_fields

  !> Effective stress sigma' = sigma + p.
  pure function effective_stress(self, stress, state) result(effective)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp) :: effective(size(stress))

    effective = self%law%effective_stress(stress, state(:self%law%state_count))
    effective(:3) = effective(:3) + state(self%state_count)
  end function effective_stress

  !> Shear modulus of the inner law.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)

    shear = self%law%shear_modulus(stress, state(:self%law%state_count))
  end function shear_modulus

  !> Shear compliance of the inner law at the effective stress.
  pure function shear_compliance(self, stress, state, volume_ratio, volume_change) result(compliance)
    class(undrained_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:), volume_ratio, volume_change
    real(wp) :: compliance(2)

    compliance = self%law%shear_compliance(self%effective_stress(stress, state), state(:self%law%state_count), &
      volume_ratio, volume_change)
  end function shear_compliance
end module qsmpm_undrained_law
