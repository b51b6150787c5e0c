!> Mirror images among the bodies that come and go: what a phase does to a body it does to its image.
module qsmpm_mirror_stages
  use qsmpm_active_bodies, only: body_number
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_change_type
  use qsmpm_mirror_images, only: body_partner
  use qsmpm_reduction, only: refuse, place_text
  implicit none
  private

  public :: prove_stages, drop_absent

contains

  !> Every change of a body has its image in the same phase.
  pure subroutine prove_stages(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(inout) :: reason
    integer :: p

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        call prove_list(analysis, phase%activations, 'ACTIVATE', axis, reason)
        call prove_list(analysis, phase%deactivations, 'DEACTIVATE', axis, reason)
        call prove_list(analysis, phase%materials, 'CHANGE MATERIAL', axis, reason)
      end associate
    end do
  end subroutine prove_stages

  !> The same of one card.
  pure subroutine prove_list(analysis, changes, keyword, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(body_change_type), intent(in) :: changes(:)
    character(len=*), intent(in) :: keyword
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: i, k, b, partner
    logical :: found

    do i = 1, size(changes)
      b = body_number(analysis, changes(i)%body)
      partner = body_partner(analysis, b, axis)
      found = .false.
      do k = 1, size(changes)
        if (partner == 0) exit
        if (changes(k)%body /= analysis%bodies(partner)%name) cycle
        found = .true.
        if (allocated(changes(i)%material)) found = changes(k)%material == changes(i)%material
      end do
      if (.not. found) call refuse(reason, '*'//keyword//" of '"//changes(i)%body//"'"// &
        place_text(changes(i)%where)//' has no mirror image')
    end do
  end subroutine prove_list

  !> Leave out the changes of bodies that are left out.
  pure subroutine drop_absent(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: p

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        call drop_from(analysis, phase%activations)
        call drop_from(analysis, phase%deactivations)
        call drop_from(analysis, phase%materials)
      end associate
    end do
  end subroutine drop_absent

  !> The same in one list.
  pure subroutine drop_from(analysis, changes)
    type(analysis_type), intent(in) :: analysis
    type(body_change_type), allocatable, intent(inout) :: changes(:)
    integer :: i

    changes = changes(pack([(i, i=1, size(changes))], &
      [(body_number(analysis, changes(i)%body) > 0, i=1, size(changes))]))
  end subroutine drop_from
end module qsmpm_mirror_stages
