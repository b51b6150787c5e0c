!> The law of a soil model, common to UMAT, UDSM, users' Fortran models and callbacks.
!>
!> A point's strain increment and rotation are computed by qsmpm_step_turn; stress and strain at the start are rotated
!> before the model is called, and its stress is the Cauchy stress at the end. Then
!>   Q = det(F) sigma F^-T,   A = dQ/dF by the model's tangent.
!> A step begins with zero strain: for a model that fails there, stress and state are kept, with the tangent by
!> differences around it. A is as accurate as the tangent; qsmpm_step_turn defines for which models it is exact.
!> Points store the deformation gradient (9) and the strain (6) before the model's own state when the model uses
!> them. Models that are not thread safe are called by one thread at a time.
module qsmpm_soil_model_law
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_finite, only: is_usable, unusable
  use qsmpm_kinds, only: wp
  use qsmpm_difference_tangent, only: difference_tangent
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, status_failed, status_unrecoverable, tangent_none, &
    tangent_elastic, unnamed_states
  use qsmpm_point_result, only: finish_points
  use qsmpm_rest_check, only: changes_at_rest, what_changes, rest_is_faulty
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_step_turn, only: step_turn_type, make_step_turn, turned_stress, turned_strain, step_tangent
  use qsmpm_tensor, only: determinant, identity, inverse, unpack_gradient, unpack_symmetric, pack_gradient, stress_size
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: soil_model_law_type, make_soil_model_law

  !> Components of a packed gradient in 2D among the nine components.
  integer, parameter :: in_plane(5) = [1, 2, 4, 5, 9]

  !> The law of a soil model.
  type, extends(law_type) :: soil_model_law_type
    class(soil_model_type), allocatable :: model
    !> Name of the material, for messages.
    character(len=:), allocatable :: name
    !> Number of state variables before the strain, and before the model's own state.
    integer :: before_strain = 0
    integer :: before_own = 0
  contains
    procedure :: start_at
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: shear_modulus
  end type soil_model_law_type

contains

  !> Makes the law of a soil model.
  subroutine make_soil_model_law(model, dimension, law)
    class(soil_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(soil_model_law_type), intent(out) :: law

    allocate (law%model, source=model)
    law%name = ''
    law%model_traits_type = model%model_traits_type
    law%dimension = dimension
    law%before_strain = merge(9, 0, model%reads_gradient)
    law%before_own = law%before_strain + merge(6, 0, model%reads_strain)
    law%state_count = law%before_own + model%state_count
    law%asks_where = .true.
    law%of_user = .true.
    if (allocated(model%state_names)) law%state_names = [unnamed_states(law%before_own), model%state_names]
  end subroutine make_soil_model_law

  !> Initialises the state of an undeformed point with a given stress.
  subroutine start_at(self, stress, place, state)
    class(soil_model_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6), and position (3).
    real(wp), intent(in) :: stress(:), place(3)
    !> State (state_count).
    real(wp), intent(out) :: state(:)
    real(wp) :: full_stress(6)

    full_stress = 0.0_wp
    full_stress(:size(stress)) = stress
    state(:self%before_own) = 0.0_wp
    if (self%before_strain > 0) state([1, 5, 9]) = 1.0_wp
    if (self%model%thread_safe) then
      call self%model%start_at(full_stress, place, state(self%before_own + 1:self%state_count))
    else
      !$omp critical (qsmpm_soil_model)
      call self%model%start_at(full_stress, place, state(self%before_own + 1:self%state_count))
      !$omp end critical (qsmpm_soil_model)
    end if
  end subroutine start_at

  !> Updates a batch.
  subroutine update(self, batch, tangent)
    class(soil_model_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    integer :: p

    do p = 1, batch%count
      if (self%model%thread_safe) then
        call update_point(self, batch, p, tangent)
      else
        !$omp critical (qsmpm_soil_model)
        call update_point(self, batch, p, tangent)
        !$omp end critical (qsmpm_soil_model)
      end if
    end do
    call finish_points(batch, tangent)
  end subroutine update

  !> Updates a point; it is incomplete with a status other than ok.
  subroutine update_point(self, batch, p, tangent)
    class(soil_model_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> Number of the point; requested tangent.
    integer, intent(in) :: p, tangent
    type(step_turn_type) :: turn
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    real(wp) :: f(3, 3), stress(6), det
    logical :: ok

    batch%plastic(p) = 0
    batch%status(p) = status_cut
    f = unpack_gradient(batch%gradient(:, p))
    det = determinant(f)
    if (.not. ieee_is_finite(det)) return
    ok = det > 0.0_wp
    if (ok) call make_step_turn(f, turn, ok)
    if (.not. ok) return
    stress = 0.0_wp
    stress(:size(batch%stress, 1)) = batch%stress_start(:, p)
    stress = turned_stress(turn, stress)
    call describe_step(self, batch, p, turn, f, increment)
    increment%wants_tangent = tangent /= tangent_none
    increment%elastic_tangent = tangent == tangent_elastic
    call ask_model(self, increment, stress, batch%state_start(:, p), batch%state(:, p), response)
    batch%status(p) = response%status
    if (response%status == status_ok) call check_answer(increment, stress, batch%state(:self%state_count, p), response)
    if (response%status == status_ok .and. .not. any(abs(f - identity) > 0.0_wp)) &
      call check_rest(self, batch, p, increment, stress, response)
    if (response%status == status_failed .and. .not. any(abs(increment%strain) > 0.0_wp)) then
      stress = 0.0_wp
      stress(:size(batch%stress, 1)) = batch%stress_start(:, p)
      call rest(self, increment, turned_stress(turn, stress), batch%state_start(:, p), batch%state(:, p), response)
      stress = turned_stress(turn, stress)
    end if
    if (response%status /= status_ok) then
      call report(self, increment, response, batch, p)
      return
    end if
    batch%plastic(p) = merge(1, 0, response%plastic)
    batch%stress(:, p) = stress(:size(batch%stress, 1))
    call finish_point(self, batch, p, tangent, turn, f, det, stress, response%tangent)
  end subroutine update_point

  !> Sets the input of the model in addition to stress and state.
  subroutine describe_step(self, batch, p, turn, f, increment)
    class(soil_model_law_type), intent(in) :: self
    type(batch_type), intent(in) :: batch
    !> Number of the point in the batch.
    integer, intent(in) :: p
    type(step_turn_type), intent(in) :: turn
    !> Incremental deformation gradient.
    real(wp), intent(in) :: f(3, 3)
    !> Input of the model.
    type(soil_increment_type), intent(inout) :: increment

    increment%strain = turn%strain
    increment%rotation = turn%rotation
    increment%gradient_end = f
    if (self%before_strain > 0) then
      increment%gradient_start = unpack_gradient(batch%state_start(1:9, p))
      increment%gradient_end = matmul(f, increment%gradient_start)
    end if
    if (self%before_own > self%before_strain) increment%strain_start = turned_strain(turn, &
      batch%state_start(self%before_strain + 1:self%before_own, p))
    increment%step_info = batch%step_info
    if (.not. allocated(batch%number)) return
    increment%point = max(1, batch%number(p))
    increment%cell = max(1, batch%cell(p))
    increment%place(:self%dimension) = batch%place(:self%dimension, p)
    increment%cell_size = batch%cell_size(p)
    if (allocated(batch%water)) increment%water = batch%water(:, p)
  end subroutine describe_step

  !> Calls the model.
  subroutine ask_model(self, increment, stress, state_start, state, response)
    class(soil_model_law_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State at the start (state_count or more).
    real(wp), intent(in) :: state_start(:)
    !> State at the end (state_count or more).
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response

    state = state_start
    if (self%before_strain > 0) call pack_gradient(increment%gradient_end, state(1:9))
    if (self%before_own > self%before_strain) state(self%before_strain + 1:self%before_own) = &
      increment%strain_start + increment%strain
    call self%model%update(increment, stress, state(self%before_own + 1:self%state_count), response)
  end subroutine ask_model

  !> Keeps stress and state at zero strain, with the tangent of small strains around it. If the model rejects those as
  !> well, there is no result.
  subroutine rest(self, increment, stress, state_start, state, response)
    class(soil_model_law_type), intent(in) :: self
    !> A step without strain.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress, rotated (6); state at the start and at the end (state_count or more).
    real(wp), intent(in) :: stress(6), state_start(:)
    real(wp), intent(inout) :: state(:)
    !> Response of the model; unchanged if it fails.
    type(soil_response_type), intent(inout) :: response
    type(soil_response_type) :: said

    associate (own => state_start(self%before_own + 1:self%state_count))
      said%status = status_ok
      if (increment%wants_tangent) call difference_tangent(self%model, increment, stress, own, said)
      if (said%status == status_unrecoverable) response = said
      if (said%status /= status_ok .or. .not. all(is_usable(said%tangent))) return
      state(self%before_own + 1:self%state_count) = own
    end associate
    response = said
  end subroutine rest

  !> Rejects a model whose stress changes at zero strain, unless it returns to its yield surface or flows with time.
  subroutine check_rest(self, batch, p, increment, stress, response)
    class(soil_model_law_type), intent(in) :: self
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> A step without strain.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the end (6).
    real(wp), intent(in) :: stress(6)
    type(soil_response_type), intent(inout) :: response
    real(wp) :: start(6)
    integer :: what

    start = 0.0_wp
    start(:size(batch%stress_start, 1)) = batch%stress_start(:, p)
    if (.not. changes_at_rest(start, stress)) return
    associate (before => [start, batch%state_start(self%before_own + 1:self%state_count, p)], &
      after => [stress, batch%state(self%before_own + 1:self%state_count, p)])
      call what_changes(self%model, increment, before, after, what)
    end associate
    if (what /= rest_is_faulty) return
    response%status = status_unrecoverable
    response%message = 'the model changes the stress where nothing is strained, again with every call and whatever '// &
      'the time increment: by '//rounded_text(maxval(abs(stress - start)))
  end subroutine check_rest

  !> Checks that a model with status ok has returned usable numbers.
  subroutine check_answer(increment, stress, state, response)
    type(soil_increment_type), intent(in) :: increment
    !> Stress and state at the end.
    real(wp), intent(in) :: stress(:), state(:)
    type(soil_response_type), intent(inout) :: response
    character(len=:), allocatable :: what

    what = ''
    if (increment%wants_tangent) then
      if (.not. all(is_usable(response%tangent))) what = 'a tangent'
    end if
    if (.not. all(is_usable(state))) what = 'a state'
    if (.not. all(is_usable(stress))) what = 'a stress'
    if (len(what) == 0) return
    response%status = status_failed
    if (allocated(response%message)) then
      what = what//unusable//'; '//response%message
    else
      what = what//unusable
    end if
    response%message = 'the model returns '//what
  end subroutine check_answer

  !> Reports why a point could not be updated, and where it is.
  subroutine report(self, increment, response, batch, p)
    class(soil_model_law_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    type(soil_response_type), intent(in) :: response
    type(batch_type), intent(inout) :: batch
    !> Number of the point in the batch.
    integer, intent(in) :: p
    character(len=:), allocatable :: place

    batch%status(p) = response%status
    if (response%share > 0.0_wp .and. (response%share < batch%share .or. .not. batch%share > 0.0_wp)) &
      batch%share = response%share
    place = 'cell '//integer_text(increment%cell)
    if (allocated(batch%number)) then
      if (batch%number(p) > 0) place = 'material point '//integer_text(batch%number(p))
    end if
    batch%message = 'the model refuses the step'
    if (allocated(response%message)) batch%message = response%message
    if (len(self%name) > 0) batch%message = "material '"//self%name//"': "//batch%message
    batch%message = batch%message//'; '//place//', phase '// &
      integer_text(increment%step_info%phase)//', step '//integer_text(increment%step_info%step)
  end subroutine report

  !> Computes Q and A of a point.
  subroutine finish_point(self, batch, p, tangent, turn, f, det, stress, modulus)
    class(soil_model_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> Number of the point, and requested tangent.
    integer, intent(in) :: p, tangent
    type(step_turn_type), intent(in) :: turn
    !> Incremental deformation gradient and its determinant.
    real(wp), intent(in) :: f(3, 3), det
    !> Cauchy stress at the end (6); d stress / d strain (6,6).
    real(wp), intent(in) :: stress(6), modulus(6, 6)
    real(wp) :: back(3, 3), a(9, 9)
    logical :: symmetric

    back = inverse(f, det)
    call pack_gradient(det*matmul(unpack_symmetric(stress), transpose(back)), batch%piola(:, p))
    if (tangent == tangent_none) return
    symmetric = self%symmetric .or. tangent == tangent_elastic
    call step_tangent(turn, stress, modulus, symmetric, back, det, a)
    if (symmetric) a = 0.5_wp*(a + transpose(a))
    if (self%dimension == 2) then
      batch%tangent(:, :, p) = a(in_plane, in_plane)
    else
      batch%tangent(:, :, p) = a
    end if
  end subroutine finish_point

  !> Number of stress and state components.
  pure integer function fit_count(self)
    class(soil_model_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension) + self%state_count
  end function fit_count

  !> Converts to fields that may be averaged: the Cauchy stress and the state.
  pure subroutine to_fields(self, stress, state, fields)
    class(soil_model_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6); state (state_count or more).
    real(wp), intent(in) :: stress(:), state(:)
    !> Fields (fit_count).
    real(wp), intent(out) :: fields(:)

    fields(1:self%fit_count()) = [stress, state(1:self%state_count)]
  end subroutine to_fields

  !> Returns stress and state of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(soil_model_law_type), intent(in) :: self
    !> Fields (fit_count); V/V0, which is not used.
    real(wp), intent(in) :: fields(:), volume_ratio
    !> Cauchy stress (4 or 6); state (state_count or more).
    real(wp), intent(out) :: stress(:), state(:)

    stress = fields(1:size(stress))
    state(1:self%state_count) = fields(size(stress) + 1:self%fit_count())
  end subroutine from_fields

  !> Shear modulus G of the model.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(soil_model_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)

    shear = self%model%shear_modulus(stress, state(self%before_own + 1:self%state_count))
  end function shear_modulus
end module qsmpm_soil_model_law
