! A UMAT and a UDSM that write down every argument they are called with, and answer with a full, unsymmetric tangent
! of known entries, so that a test can check each slot.
module record
  implicit none
  double precision :: reals(400) = 0
  integer :: integers(100) = 0
  character(len=80) :: name = ' '
end module record

subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
    dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, &
    dfgrd1, noel, npt, layer, kspt, jstep, kinc)
  use record
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc, i, j
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), &
    drplde(ntens), drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*), &
    props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=*) :: cmname

  reals = 0
  reals(1:ntens) = stress
  reals(11:10 + nstatv) = statev
  reals(21:26) = [sse, spd, scd, rpl, drpldt, ddsdde(1, 1)]
  reals(31:30 + ntens) = stran
  reals(41:40 + ntens) = dstran
  reals(51:58) = [time(1), time(2), dtime, temp, dtemp, predef(1), dpred(1), predef(2)]
  reals(61:60 + nprops) = props
  reals(71:73) = coords
  reals(74:75) = [pnewdt, celent]
  reals(81:89) = reshape(drot, [9])
  reals(91:99) = reshape(dfgrd0, [9])
  reals(101:109) = reshape(dfgrd1, [9])
  reals(111:112) = [ddsddt(ntens), drplde(ntens)]
  integers(1:14) = [ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep, kinc]
  name = cmname
  integers(15) = len(cmname)
  ! Scratch that must be there.
  ddsddt = 1
  drplde = 1
  do i = 1, ntens
    stress(i) = stress(i) + 100*i
    do j = 1, ntens
      ddsdde(i, j) = 10*i + j
    end do
  end do
  statev = statev + 1
end subroutine umat

subroutine user_mod(idtask, imod, isundr, istep, iter, iel, int, x, y, z, time0, dtime, props, sig0, swp0, stvar0, &
    deps, d, bulkw, sig, swp, stvar, ipl, nstat, nonsym, istrsdep, itimedep, itang, iprjdir, iprjlen, iabort)
  use record
  implicit none
  integer :: idtask, imod, isundr, istep, iter, iel, int, ipl, nstat, nonsym, istrsdep, itimedep, itang, iprjdir(*), &
    iprjlen, iabort, i, j
  double precision :: x, y, z, time0, dtime, props(50), sig0(20), swp0, stvar0(*), deps(12), d(6, 6), bulkw, sig(6), &
    swp, stvar(*)

  select case (idtask)
  case (1)
    stvar0(1:2) = [7, 8]
    props(20) = 20
  case (2)
    reals = 0
    reals(1:20) = sig0
    reals(21:32) = deps
    reals(41:90) = props
    reals(91:97) = [x, y, z, time0, dtime, swp0, bulkw]
    reals(101:102) = stvar0(1:2)
    reals(111:146) = reshape(d, [36])
    reals(151:156) = sig(1:6)
    integers(21:27) = [imod, isundr, istep, iter, iel, int, iprjlen]
    integers(28:27 + iprjlen) = iprjdir(1:iprjlen)
    integers(40:45) = [ipl, nstat, nonsym, istrsdep, itimedep, itang]
    integers(46) = iabort
    do i = 1, 6
      sig(i) = sig0(i) + 100*i
    end do
    swp = swp0 + 5
    stvar(1:2) = stvar0(1:2) + 1
    ipl = 1
  case (3)
    do i = 1, 6
      do j = 1, 6
        d(i, j) = 10*i + j
      end do
    end do
  case (4)
    nstat = 2
  case (5)
    nonsym = 1
    istrsdep = 1
    itimedep = 0
    itang = 1
  case (6)
    d = 0
    do i = 1, 6
      d(i, i) = 1000 + i
    end do
  end select
end subroutine user_mod

! What was written down last.
subroutine recall(r, i, n)
  use record
  implicit none
  double precision :: r(400)
  integer :: i(100)
  character(len=1) :: n(80)
  integer :: k

  r = reals
  i = integers
  do k = 1, 80
    n(k) = name(k:k)
  end do
end subroutine recall
