!> Strengths that follow the effective stress of their points (SHANSEP, Ladd and Foott 1974): updated where a phase asks
!> for it, and what the log says of them.
module qsmpm_strength_update
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_strength_profile, only: follows_stress
  use qsmpm_team, only: largest, smallest
  implicit none
  private

  public :: update_strengths, strength_note

contains

  !> Strengths by the present stresses.
  pure subroutine update_strengths(model)
    type(model_type), intent(inout) :: model
    integer :: p

    associate (points => model%state%points)
      do p = 1, points%count
        associate (law => model%laws(points%material(p))%law)
          call law%strengthen(points%stress(:, p), points%state(:law%state_count, p))
        end associate
      end do
    end associate
  end subroutine update_strengths

  !> A line for each material of such a strength: the range that its points have.
  function strength_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: range(2)
    logical :: of_soil(model%state%points%count)
    integer :: m, i

    text = ''
    associate (points => model%state%points, team => model%part%team)
      do m = 1, size(model%laws)
        if (.not. follows_stress(model%analysis%materials(m)%strength_profile)) cycle
        of_soil = own_of(model%part%points, points%count) .and. points%material == m
        associate (names => model%laws(m)%law%state_names)
          do i = 1, size(names)
            if (names(i)%text /= 'undrained_strength') cycle
            associate (strength => points%state(i, :points%count))
              range = [smallest(team, minval(strength, of_soil)), largest(team, maxval(strength, of_soil))]
            end associate
            if (range(1) <= range(2)) text = text//"material '"//model%analysis%materials(m)%name// &
              "': strength by the stress from "//rounded_text(range(1))//' to '//rounded_text(range(2))//new_line('a')
          end do
        end associate
      end do
    end associate
  end function strength_note
end module qsmpm_strength_update
