!> Stresses taken from the results of another run (*INITIAL, TYPE=GIVEN, INPUT=results.h5): whether its material lay
!> where that of the model is, and the state variables that come with them. docs/methods/initial_stresses.md.
module qsmpm_initial_results
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_stress_type
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_model, only: model_type
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_stress_results, only: read_state_results
  use qsmpm_team, only: largest
  use qsmpm_rounded_text, only: rounded_place
  use qsmpm_text, only: word_place
  implicit none
  private

  public :: check_initial_results, take_states

contains

  !> Refuse results of material that lay elsewhere; read the state variables that the laws of the model know.
  subroutine check_initial_results(model, diagnostics)
    !> With its laws and points.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics

    if (size(model%analysis%phases) == 0) return
    associate (initial => model%analysis%phases(1)%initial)
      if (.not. allocated(initial%part)) return
      call check_distances(model, initial, diagnostics)
      if (initial%takes_state) call read_states(model%laws, initial, diagnostics)
    end associate
  end subroutine check_initial_results

  !> Every material point that is there at the start has one of the other run within a cell.
  subroutine check_distances(model, initial, diagnostics)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    type(diagnostics_type), intent(inout) :: diagnostics
    type(point_bins_type) :: bins
    real(wp) :: distance, farthest, farthest_of_all
    character(len=:), allocatable :: place
    integer :: p, worst, rank

    call make_bins(initial%places, bins)
    farthest = 1.0_wp
    worst = 0
    associate (points => model%state%points)
      do p = 1, points%count
        if (.not. model%analysis%bodies(points%body(p))%active) cycle
        distance = norm2(initial%places(:, nearest_in_bins(bins, initial%places, points%position(:, p))) &
          - points%position(:, p))/cell_size(model%mesh, points%cell(p))
        if (.not. distance > farthest) cycle
        farthest = distance
        worst = p
      end do
      place = ''
      if (worst > 0) place = rounded_place(points%position(:, worst))
    end associate
    farthest_of_all = largest(model%part%team, farthest)
    rank = lowest_rank(model%part%team, worst > 0 .and. farthest >= farthest_of_all)
    if (rank == model%part%team%ranks) return
    call spread_text(model%part%team, rank, place)
    call add_diagnostic(diagnostics, initial%where, '*INITIAL', "'"//initial%file//"' has no material point within "// &
      'a cell of '//place//': that run had no material there; leave the body out by ACTIVE=NO and put it in '// &
      'place later, or give stresses by height')
  end subroutine check_distances

  !> Read the state variables that both runs have.
  subroutine read_states(laws, initial, diagnostics)
    type(law_slot_type), intent(in) :: laws(:)
    type(initial_stress_type), intent(inout) :: initial
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error
    real(wp), allocatable :: values(:)
    integer :: m, i, n

    allocate (initial%state_names(0), initial%state_at_places(0, size(initial%places, 2)))
    do m = 1, size(laws)
      if (.not. allocated(laws(m)%law%state_names)) cycle
      do i = 1, size(laws(m)%law%state_names)
        associate (name => laws(m)%law%state_names(i)%text)
          if (len(name) == 0 .or. word_place(initial%state_names, name) > 0) cycle
          call read_state_results(initial%part, name, values, initial%material_at_places, error)
          if (allocated(error)) then
            call add_diagnostic(diagnostics, initial%where, '*INITIAL', error%message)
            return
          end if
          if (.not. allocated(values)) cycle
          n = size(initial%state_names)
          initial%state_names = [initial%state_names, laws(m)%law%state_names(i)]
          initial%state_at_places = transpose(reshape([transpose(initial%state_at_places), values], &
            [size(values), n + 1]))
        end associate
      end do
    end do
    if (size(initial%state_names) == 0) call add_diagnostic(diagnostics, initial%where, '*INITIAL', &
      "'"//initial%file//"' has no state variable of the materials of this model: leave out STATE=YES")
  end subroutine read_states

  !> State variables of the nearest place, where the material has the same number.
  subroutine take_states(model, initial)
    type(model_type), intent(inout) :: model
    !> With its state variables.
    type(initial_stress_type), intent(in) :: initial
    type(point_bins_type) :: bins
    integer :: p, i, k, from

    call make_bins(initial%places, bins)
    associate (points => model%state%points)
      do p = 1, points%count
        from = nearest_in_bins(bins, initial%places, points%position(:, p))
        if (initial%material_at_places(from) /= points%material(p)) cycle
        associate (law => model%laws(points%material(p))%law)
          if (.not. allocated(law%state_names)) cycle
          do i = 1, size(law%state_names)
            k = word_place(initial%state_names, law%state_names(i)%text)
            if (k > 0) points%state(i, p) = initial%state_at_places(k, from)
          end do
        end associate
      end do
    end associate
  end subroutine take_states
end module qsmpm_initial_results
