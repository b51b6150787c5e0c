!> Cavities that phases contract (*CONTRACTION), like a lining that shrinks uniformly: every point of the outline moves
!> towards the centre by the same share c of its distance from it, so that for a volume loss V
!>
!>   (1 - c)^2 A = (1 - V) A            c = 1 - sqrt(1 - V)
!>
!> for any outline; a circle moves along its normals. The centre is the place closest to the normals of all points. A
!> half or a quarter of a circle between planes of symmetry has the centre of the circle.
module qsmpm_cavities
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_analysis, only: plane_strain
  use qsmpm_load_description, only: support_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_named, only: place_named
  use qsmpm_model, only: model_type
  use qsmpm_overburden, only: body_holds, make_overburden, overburden_type
  use qsmpm_own_part, only: own_cells
  use qsmpm_vertical, only: vertical_of
  use qsmpm_team, only: total, largest, smallest
  implicit none
  private

  public :: measure_cavities, closure_of

  !> Ratio of the sum of the normals of a closed outline to its length, and of the radius of the points of an arc to
  !> that of its chords.
  real(wp), parameter :: closed = 1.0e-3_wp, round = 1.05_wp

contains

  !> Finds the centres of all cavities.
  subroutine measure_cavities(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, i, s

    allocate (model%cavity_middle(2, size(model%analysis%surfaces)), source=0.0_wp)
    do p = 1, size(model%analysis%phases)
      do i = 1, size(model%analysis%phases(p)%supports)
        associate (support => model%analysis%phases(p)%supports(i))
          s = place_named(model%analysis%surfaces, support%surface)
          if (.not. support%contracts .or. s == 0) cycle
          call measure_cavity(model, s, support, diagnostics)
          call warn_of_core(model, s, p, support)
        end associate
      end do
    end do
  end subroutine measure_cavities

  !> Warns of soil that a phase leaves inside an outline: its weight acts on a lining that has no weight.
  subroutine warn_of_core(model, s, p, support)
    type(model_type), intent(inout) :: model
    !> Numbers of the surface and of the phase, and the contraction.
    integer, intent(in) :: s, p
    type(support_type), intent(in) :: support
    type(overburden_type) :: ground
    real(wp) :: inside(2), sums(3), area(model%state%surface%count)
    logical :: active(size(model%analysis%bodies))
    integer :: b

    associate (surface => model%state%surface)
      area = merge(surface%area, 0.0_wp, surface%surface == s .and. own_cells(model%part, surface%cell))
      sums = total(model%part%team, [matmul(surface%position(:2, :), area), sum(area)])
    end associate
    if (.not. sums(3) > 0.0_wp) return
    ! The centre of half an outline is on the edge of the area that it encloses.
    inside = 0.7_wp*model%cavity_middle(:, s) + 0.3_wp*sums(:2)/sums(3)
    call make_overburden(model%mesh, model%shapes, [(0.0_wp, b=1, size(model%shapes))], &
      vertical_of(model%analysis), ground)
    active = bodies_active(model%analysis, p)
    do b = 1, size(active)
      if (.not. (active(b) .and. body_holds(ground, b, inside))) cycle
      model%notes = model%notes//"warning: *CONTRACTION: body '"//model%analysis%bodies(b)%name//"' fills surface '"// &
        support%surface//"' in phase '"//model%analysis%phases(p)%name//"', and its weight loads the contracting "// &
        'outline: define the inside as a separate body and *DEACTIVATE it'//new_line('a')
    end do
  end subroutine warn_of_core

  !> Finds the centre of one cavity.
  subroutine measure_cavity(model, s, support, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the surface, and the contraction.
    integer, intent(in) :: s
    type(support_type), intent(in) :: support
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: across(2, 2), sums(8), determinant, farthest, nearest
    real(wp), dimension(model%state%surface%count) :: radius, reach
    logical :: own(model%state%surface%count)
    integer :: k

    associate (surface => model%state%surface)
      if (model%analysis%model /= plane_strain) then
        call refuse('can be contracted in plane strain only')
        return
      end if
      own = surface%surface == s .and. own_cells(model%part, surface%cell)
      sums = 0.0_wp
      do k = 1, surface%count
        if (.not. own(k)) cycle
        associate (n => surface%normal(:, k), a => surface%area(k))
          across = a*reshape([n(2)*n(2), -n(1)*n(2), -n(1)*n(2), n(1)*n(1)], [2, 2])
          sums = sums + [a, a*n, across(1, :), across(2, 2), matmul(across, surface%position(:, k))]
        end associate
      end do
      sums = total(model%part%team, sums)
      determinant = sums(4)*sums(6) - sums(5)**2
      if (determinant > closed*sums(1)**2) then
        associate (middle => model%cavity_middle(:, s))
          middle = [sums(6)*sums(7) - sums(5)*sums(8), sums(4)*sums(8) - sums(5)*sums(7)]/determinant
          do k = 1, surface%count
            radius(k) = abs(dot_product(surface%normal(:, k), middle - surface%position(:, k)))
            reach(k) = norm2(middle - surface%position(:, k))
          end do
        end associate
        farthest = largest(model%part%team, maxval(reach, mask=own))
        nearest = smallest(model%part%team, minval(radius, mask=own))
        if (norm2(sums(2:3)) <= closed*sums(1) .or. farthest <= round*nearest) then
          ! The upward forces of the other half are missing: the springs of this half push without balance.
          if (abs(sums(1 + vertical_of(model%analysis))) > closed*sums(1) .and. .not. support%held) call refuse( &
            'ends at a horizontal plane of symmetry, on which its centre remains: HELD=YES')
          return
        end if
      end if
      call refuse('is neither closed nor an arc of a circle: the whole outline of a cavity is contracted, or half '// &
        'or a quarter of a circle that ends at planes of symmetry')
    end associate

  contains

    !> Reports why the surface cannot be contracted.
    subroutine refuse(what)
      character(len=*), intent(in) :: what

      call add_diagnostic(diagnostics, support%where, '*CONTRACTION', "surface '"//support%surface//"' "//what)
    end subroutine refuse
  end subroutine measure_cavity

  !> Returns the share of their distance from the centre by which the points of an outline have moved.
  elemental real(wp) function closure_of(percent) result(closure)
    !> Area loss in percent.
    real(wp), intent(in) :: percent

    closure = 1.0_wp - sqrt(max(0.0_wp, 1.0_wp - 0.01_wp*percent))
  end function closure_of
end module qsmpm_cavities
