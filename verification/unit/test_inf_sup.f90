!> Displacements and pore pressures of consolidation are a pair that is stable without flow: the constant
!>
!>   beta^2 = min  q B A^-1 B^T q / q M q,     A of 2 G strain:strain,  B of q div u,  M of q^2, over 2 G
!>
!> stays as the cells become small (Brezzi, Babuska), on triangles that fit a unit square whose base and sides are held.
module test_inf_sup
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_element, only: corner_count, linear_kind, shape_functions
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_space, only: functions_at, shape_values_type
  use qsmpm_text, only: integer_text
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_inf_sup

  interface
    !> LAPACK: factors of a symmetric positive definite matrix.
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: wp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(wp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf

    !> LAPACK: solution of a triangular system.
    subroutine dtrtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
      import :: wp
      character(len=1), intent(in) :: uplo, trans, diag
      integer, intent(in) :: n, nrhs, lda, ldb
      real(wp), intent(in) :: a(lda, *)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dtrtrs

    !> LAPACK: eigenvalues of a symmetric matrix by another, positive definite one.
    subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
      import :: wp
      integer, intent(in) :: itype, n, lda, ldb, lwork
      character(len=1), intent(in) :: jobz, uplo
      real(wp), intent(inout) :: a(lda, *), b(ldb, *)
      real(wp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsygv
  end interface

contains

  !> All checks.
  subroutine collect_inf_sup(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: constant(3)
    integer, parameter :: cells(3) = [6, 12, 20]
    integer :: i

    call tests%start('inf_sup')
    do i = 1, 3
      constant(i) = constant_of(cells(i))
      call tests%check(integer_text(cells(i))//' cells: pressures and displacements are a stable pair', &
        constant(i) > 0.6_wp)
    end do
    call tests%check('its constant does not fall with the cell', constant(3) >= 0.95_wp*constant(1))
  end subroutine collect_inf_sup

  !> The constant on so many cells.
  real(wp) function constant_of(cells) result(constant)
    integer, intent(in) :: cells
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis, model, step)
    call parse_deck('square.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 1, '//integer_text(cells)// &
      '| Y, 0, 1, '//integer_text(cells)//'|*MATERIAL, NAME=soil|*ELASTIC| 1, 0|*PERMEABILITY| 1|'// &
      '*BODY, NAME=soil, MATERIAL=soil, SHAPE=BOX| 0, 1, 0, 1|*PHASE, NAME=one, TIME=1|'// &
      '*GRAVITY| 0, -1|*CONSOLIDATION, UNIT WEIGHT=1|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the inf-sup suite is broken'
    call begin_analysis(model, step%terms)
    constant = smallest_quotient(model)
  end function constant_of

  !> Root of the smallest quotient.
  real(wp) function smallest_quotient(model) result(root)
    type(model_type), intent(in) :: model
    real(wp), allocatable :: stiffness(:, :), divergence(:, :), mass(:, :), schur(:, :), value(:), work(:)
    type(shape_values_type) :: place
    real(wp) :: shape(8), strain(2, 2)
    integer :: row(2, model%space%node_count), column(model%mesh%node_count), p, a, b, i, j, n, m, corners, info

    call number_nodes(model, row, column)
    n = maxval(row)
    m = maxval(column)
    allocate (stiffness(n, n), divergence(n, m), mass(m, m), source=0.0_wp)
    associate (points => model%state%points)
      do p = 1, points%count
        call functions_at(model%space, model%mesh, points%cell(p), points%local(:, p), place)
        corners = corner_count(model%mesh%cell_kind(points%cell(p)))
        call shape_functions(linear_kind(model%mesh%cell_kind(points%cell(p))), points%local(:, p), shape(:corners))
        associate (node => place%node, gradient => place%gradient, volume => points%volume(p))
          do a = 1, place%count
            do i = 1, 2
              if (row(i, node(a)) == 0) cycle
              do b = 1, corners
                divergence(row(i, node(a)), column(node(b))) = divergence(row(i, node(a)), column(node(b))) &
                  + volume*gradient(i, a)*shape(b)
              end do
              do b = 1, place%count
                ! 2 strain(u):strain(v) of N_a e_i and N_b e_j.
                strain = spread(gradient(:2, b), 1, 2)*spread(gradient(:2, a), 2, 2)
                do j = 1, 2
                  if (row(j, node(b)) == 0) cycle
                  associate (entry => stiffness(row(i, node(a)), row(j, node(b))))
                    entry = entry + volume*(strain(j, i) + merge(dot_product(gradient(:2, a), gradient(:2, b)), &
                      0.0_wp, i == j))
                  end associate
                end do
              end do
            end do
          end do
          do a = 1, corners
            do b = 1, corners
              mass(column(node(a)), column(node(b))) = mass(column(node(a)), column(node(b))) + volume*shape(a)*shape(b)
            end do
          end do
        end associate
      end do
    end associate
    call dpotrf('L', n, stiffness, n, info)
    call dtrtrs('L', 'N', 'N', n, m, stiffness, n, divergence, n, info)
    ! With G = 1 the matrix is that of 2 G strain:strain, and pressures are over 2 G.
    allocate (schur(m, m), value(m), work(8*m))
    schur = 2.0_wp*matmul(transpose(divergence), divergence)
    call dsygv(1, 'N', 'L', m, schur, m, mass, m, value, work, size(work), info)
    root = sqrt(max(0.0_wp, value(1)))
  end function smallest_quotient

  !> Equations of the displacements that are free, the base and the sides being held, and of the pressures.
  subroutine number_nodes(model, row, column)
    type(model_type), intent(in) :: model
    integer, intent(out) :: row(:, :), column(:)
    integer :: c, a, i, n, m
    real(wp), parameter :: hair = 1.0e-9_wp

    row = 0
    column = 0
    n = 0
    m = 0
    associate (mesh => model%mesh)
      do c = 1, mesh%cell_count
        do a = mesh%cell_first(c), mesh%cell_first(c + 1) - 1
          associate (node => mesh%cell_nodes(a))
            if (a < mesh%cell_first(c) + corner_count(mesh%cell_kind(c)) .and. column(node) == 0) then
              m = m + 1
              column(node) = m
            end if
            if (row(1, node) + row(2, node) > 0 .or. mesh%coordinates(2, node) < hair) cycle
            do i = 1, 2
              if (i == 1 .and. abs(mesh%coordinates(1, node) - 0.5_wp) > 0.5_wp - hair) cycle
              n = n + 1
              row(i, node) = n
            end do
          end associate
        end do
      end do
    end associate
  end subroutine number_nodes
end module test_inf_sup
