module kf
  use iso_c_binding
  implicit none
contains
  subroutine fmul(terms, panel, other, value) bind(c)
    integer(c_int), value :: terms
    real(c_double), intent(in) :: panel(4,3,terms), other(4,terms)
    real(c_double), intent(out) :: value(4,4,3)
    real(c_double), dimension(4) :: a1,a2,a3,a4,b1,b2,b3,b4,c1,c2,c3,c4
    integer :: t
    a1=0;a2=0;a3=0;a4=0;b1=0;b2=0;b3=0;b4=0;c1=0;c2=0;c3=0;c4=0
    do t=1,terms
      a1=a1+panel(:,1,t)*other(1,t)
      b1=b1+panel(:,2,t)*other(1,t)
      c1=c1+panel(:,3,t)*other(1,t)
      a2=a2+panel(:,1,t)*other(2,t)
      b2=b2+panel(:,2,t)*other(2,t)
      c2=c2+panel(:,3,t)*other(2,t)
      a3=a3+panel(:,1,t)*other(3,t)
      b3=b3+panel(:,2,t)*other(3,t)
      c3=c3+panel(:,3,t)*other(3,t)
      a4=a4+panel(:,1,t)*other(4,t)
      b4=b4+panel(:,2,t)*other(4,t)
      c4=c4+panel(:,3,t)*other(4,t)
    end do
    value(:,1,1)=a1;value(:,2,1)=a2;value(:,3,1)=a3;value(:,4,1)=a4
    value(:,1,2)=b1;value(:,2,2)=b2;value(:,3,2)=b3;value(:,4,2)=b4
    value(:,1,3)=c1;value(:,2,3)=c2;value(:,3,3)=c3;value(:,4,3)=c4
  end subroutine
  subroutine gmul(terms, panel, other, value) bind(c)
    integer(c_int), value :: terms
    real(c_double), intent(in) :: panel(4,3,terms), other(4,terms)
    real(c_double), intent(out) :: value(4,4,3)
    real(c_double) :: s(4,4,3)
    integer :: t,b,p
    s=0
    do t=1,terms
      do b=1,4
        do p=1,3
          s(:,b,p)=s(:,b,p)+panel(:,p,t)*other(b,t)
        end do
      end do
    end do
    value=s
  end subroutine
end module
program bench
 use kf
 implicit none
 interface
  subroutine cmul(terms,panel,other,value) bind(c)
   import
    integer(c_int), value :: terms
    real(c_double), intent(in) :: panel(4,3,terms), other(4,terms)
    real(c_double), intent(out) :: value(4,4,3)
  end subroutine
 end interface
 real(c_double) :: panel(4,3,24), other(4,24), v(4,4,3), w(4,4,3)
 integer(8) :: c0,c1,r
 integer :: i,k
 call random_number(panel); call random_number(other)
 do k=1,3
 call system_clock(c0,r)
 do i=1,2000000
  if(k==1) call cmul(24,panel,other,v)
  if(k==2) call fmul(24,panel,other,v)
  if(k==3) call gmul(24,panel,other,v)
 end do
 call system_clock(c1)
 print *,k, real(2000000_8*24*48*2,8)/(real(c1-c0,8)/r)/1e9, sum(v)
 end do
end program
