!> Rigid bodies that touch the soil: pressure normal to the body and shear along it, on patches of the soil's
!> surface or of the outline of the body.
!>
!>   g = sum A_s phi(x_s + sum N_a u_a)/A          mean gap of a patch, the body where it is at the end of the step
!>   s = sum A_s (1 - n n')(u_s - u_body)/A        mean slip in the step, n of its start
!>   force on node a    sum A_s N_a (p n_s + (1 - n n') t)
!>   stiffness          eps A b b' - sum A_s p N_a N_b H_s + friction,   b_a = sum A_s n_s N_a/A
!>
!> with the points s of the patch, their places x_s and areas A_s at the start of the step, and p(g), t(s, p) of
!> qsmpm_contact_law. Pressure and shear of a step stay with the points as the multipliers of the next one. Surface
!> points ride on the soil: g is the whole gap. Points on the body are at no distance from it at the start of each step:
!> g is what the step opens. Pose, force and moment of a body are kept (qsmpm_rigid_bodies). docs/methods/contact.md.
module qsmpm_contacts
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_contact_law, only: tractions_type
  use qsmpm_contact_push, only: push_of_patch, tractions_of_patch, reaction_of
  use qsmpm_contact_scratch, only: contact_scratch_type, lay_scratch, body_displacement, keep_tractions, &
    keep_contact_points
  use qsmpm_equations, only: equations_type, add_block
  use qsmpm_model, only: model_type
  use qsmpm_rigid_bodies, only: motion_in_phase, keep_rigid_body
  use qsmpm_rigid_pose, only: rigid_pose_type, placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: term_type, term_slot_type, failure_type, role_external
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: contacts_type, new_contacts, bodies_at_end

  !> Cells that a body may move in one step.
  real(wp), parameter :: largest_motion = 2.0_wp

  type, extends(term_type) :: contacts_type
    type(contact_scratch_type) :: scratch
  contains
    procedure :: prepare
    procedure :: set_load
    procedure :: evaluate
    procedure :: add_force
    procedure :: add_blocks
    procedure :: commit
  end type contacts_type

contains

  !> The term.
  subroutine new_contacts(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (contacts_type :: term)
    term%name = 'force of the contacts'
    term%role = role_external
    term%anchors = .true.
  end subroutine new_contacts

  !> The rigid bodies of an analysis where they are at the end of the step.
  function bodies_at_end(terms) result(bodies)
    type(term_slot_type), intent(in) :: terms(:)
    type(placed_shape_type), allocatable :: bodies(:)
    integer :: t

    do t = 1, size(terms)
      select type (term => terms(t)%term)
      class is (contacts_type)
        allocate (bodies, source=term%scratch%now)
      end select
    end do
    if (.not. allocated(bodies)) allocate (bodies(0))
  end function bodies_at_end

  !> Patches near the bodies, with what they bring from the step before.
  subroutine prepare(self, model, configuration)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration

    call lay_scratch(self%scratch, model, configuration)
    self%connectivity = self%scratch%connectivity
    self%symmetric = all(.not. self%scratch%pairs%friction > 0.0_wp)
  end subroutine prepare

  !> Put the bodies where they are at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    type(rigid_pose_type) :: motion
    integer :: b

    associate (unused => configuration)
    end associate
    self%scratch%at_rest = .true.
    do b = 1, size(self%scratch%now)
      motion = motion_in_phase(model, b)
      associate (share => fraction - model%state%progress%fraction, before => self%scratch%before(b)%pose)
        self%scratch%now(b)%pose = rigid_pose_type(before%displacement + share*motion%displacement, &
          before%angle + share*motion%angle)
      end associate
    end do
  end subroutine set_load

  !> A body that moves so far in a step that it may pass surface points unseen loses the step.
  subroutine evaluate(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: c, k

    associate (unused => configuration, unused_displacement => displacement, unused_tangent => tangent, &
        unused_equations => equations, unused_matrix => matrix)
    end associate
    if (present(prescribed)) continue
    self%scratch%at_rest = .false.
    associate (scratch => self%scratch)
      do c = 1, size(scratch%pairs)
        associate (b => scratch%pairs(c)%body)
          call check_motion(self, model, b, scratch%before(b)%reference + scratch%before(b)%pose%displacement, failure)
        end associate
      end do
      do c = 1, scratch%patches%count
        do k = scratch%patches%first(c), scratch%patches%first(c + 1) - 1
          call check_motion(self, model, scratch%pairs(scratch%patches%pair(c))%body, scratch%place(:, k), failure)
        end do
      end do
    end associate
  end subroutine evaluate

  !> Fail where a place that rides on a body moves too far.
  subroutine check_motion(self, model, b, x, failure)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    real(wp), intent(in) :: x(3)
    type(failure_type), intent(inout) :: failure

    if (.not. norm2(body_displacement(self%scratch, b, x)) > largest_motion*model%cell_size) return
    failure%failed = .true.
    failure%reason = "rigid body '"//model%analysis%rigid_bodies(b)%name//"' moves by more than "// &
      real_text(largest_motion)//' cells in one step; more STEPS'
  end subroutine check_motion

  !> Push of the bodies.
  subroutine add_force(self, displacement, force)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: push(3, size(self%scratch%shape, 1))
    type(tractions_type) :: tractions
    integer :: c, n

    do c = 1, self%scratch%patches%count
      call push_of_patch(self%scratch, c, displacement, tractions, push)
      associate (nodes => self%connectivity%nodes(self%connectivity%first(c):self%connectivity%first(c + 1) - 1))
        n = size(nodes)
        force(:self%scratch%dimension, nodes) = force(:self%scratch%dimension, nodes) + push(:self%scratch%dimension, :n)
      end associate
    end do
  end subroutine add_force

  !> Stiffness of the contacts.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: push(3, size(self%scratch%shape, 1))
    type(tractions_type) :: tractions
    integer :: c

    do c = 1, self%scratch%patches%count
      call push_of_patch(self%scratch, c, displacement, tractions, push, block)
      if (equations%symmetric) block = 0.5_wp*(block + reshape(block, shape(block), order=[3, 4, 1, 2]))
      call add_block(equations, self%first_stencil + c - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> Points keep pressure and shear, bodies where they are and what the soil does to them.
  subroutine commit(self, displacement, model)
    class(contacts_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    type(tractions_type) :: tractions
    type(distance_type), allocatable :: distance(:)
    real(wp) :: on_body(6, size(self%scratch%now)), gap
    integer :: c, b

    on_body = 0.0_wp
    model%state%surface%contact_pressure = 0.0_wp
    model%state%surface%contact_shear = 0.0_wp
    self%scratch%on_bodies%pressure = 0.0_wp
    self%scratch%on_bodies%shear = 0.0_wp
    self%scratch%at_rest = .false.
    associate (scratch => self%scratch, patches => self%scratch%patches)
      do c = 1, patches%count
        if (allocated(distance)) deallocate (distance)
        allocate (distance(patches%first(c):patches%first(c + 1) - 1))
        call tractions_of_patch(scratch, c, displacement, distance, tractions, gap)
        call keep_tractions(scratch, c, gap, tractions, model)
        b = scratch%pairs(patches%pair(c))%body
        on_body(:, b) = on_body(:, b) + reaction_of(scratch, c, displacement, distance, tractions)
      end do
      do b = 1, size(scratch%now)
        call keep_rigid_body(model, b, scratch%now(b)%pose, on_body(:, b))
      end do
    end associate
    call keep_contact_points(self%scratch, model)
  end subroutine commit
end module qsmpm_contacts
