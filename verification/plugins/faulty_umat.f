C     Elasticity (PROPS: Young's modulus, Poisson's ratio) that goes
C     wrong. PROPS(3) says how:
C       1 STOP        2 integer division by zero   3 a bad address
C       4 NaN         5 PNEWDT, PROPS(5), where a strain is above PROPS(6)
C       6 CALL XIT    7 a run-time error of the compiler's library
C       8 ABORT       9 writes behind STATEV      10 a run-time error while
C                                                     it writes to unit 6
C      11 adds to a number behind STATEV
C      12 _exit(0)    13 overwrites NTENS   14 overwrites NSTATV
C      15 NaN at no strain
C      16 211 numbers behind STATEV   17 12 behind STRESS
C      18 2 before DDSDDE             19 behind PROPS
C      20 quick_exit(0)               21 an endless loop
C      22 half the stress again, at no strain too
C      23 so much more stress with time               24 not below -1
C      25 jumps of PROPS(5) from strain to strain
C     from the KINC of PROPS(4) on, and where PROPS(7) is given only
C     at an X above it.
      SUBROUTINE UMAT(STRESS,STATEV,DDSDDE,SSE,SPD,SCD,
     1 RPL,DDSDDT,DRPLDE,DRPLDT,STRAN,DSTRAN,TIME,DTIME,TEMP,DTEMP,
     2 PREDEF,DPRED,CMNAME,NDI,NSHR,NTENS,NSTATV,PROPS,NPROPS,COORDS,
     3 DROT,PNEWDT,CELENT,DFGRD0,DFGRD1,NOEL,NPT,LAYER,KSPT,KSTEP,KINC)
      INCLUDE 'ABA_PARAM.INC'
      CHARACTER*80 CMNAME
      CHARACTER*4 FORM
      DIMENSION STRESS(NTENS),STATEV(*),DDSDDE(NTENS,NTENS),
     1 DSTRAN(NTENS),TIME(2),PROPS(*),COORDS(3),DROT(3,3)
      POINTER (KADDR, WRONG)
      G=PROPS(1)/(2.D0*(1.D0+PROPS(2)))
      A=2.D0*G*PROPS(2)/(1.D0-2.D0*PROPS(2))
      DO 20 J=1,NTENS
        DO 10 I=1,NTENS
          DDSDDE(I,J)=0.D0
          IF(I.LE.NDI.AND.J.LE.NDI) DDSDDE(I,J)=A
   10   CONTINUE
        DDSDDE(J,J)=DDSDDE(J,J)+G
        IF(J.LE.NDI) DDSDDE(J,J)=DDSDDE(J,J)+G
   20 CONTINUE
      DO 30 J=1,NTENS
        DO 30 I=1,NTENS
          STRESS(I)=STRESS(I)+DDSDDE(I,J)*DSTRAN(J)
   30 CONTINUE
      IF(KINC.LT.NINT(PROPS(4))) RETURN
      IF(NPROPS.GE.7) THEN
        IF(COORDS(1).LT.PROPS(7)) RETURN
      END IF
      KIND=NINT(PROPS(3))
      IF(KIND.EQ.1) STOP 'factor out of range'
      IF(KIND.EQ.2) STRESS(1)=REAL(KINC/(KINC-NINT(PROPS(4))))
      IF(KIND.EQ.3) THEN
        KADDR=8
        WRONG=1.D0
      END IF
      IF(KIND.EQ.4) STRESS(2)=SQRT(-1.D0-STRESS(1)**2)
      IF(KIND.EQ.5.AND.MAXVAL(ABS(DSTRAN)).GT.PROPS(6)) PNEWDT=PROPS(5)
      IF(KIND.EQ.6) CALL XIT
      IF(KIND.EQ.7) OPEN(77,FILE='no/such/file',STATUS='OLD')
      IF(KIND.EQ.8) CALL ABORT
      IF(KIND.EQ.9) STATEV(NSTATV+1)=1.D0
      IF(KIND.EQ.11) STATEV(NSTATV+1)=STATEV(NSTATV+1)+1.D-15
      IF(KIND.EQ.12) CALL LEAVE
      IF(KIND.EQ.13) NTENS=4
      IF(KIND.EQ.14) NSTATV=NSTATV+1
      IF(KIND.EQ.15) STRESS(1)=STRESS(1)+0.D0*STRESS(1)/MAXVAL(ABS(DSTRAN))
      IF(KIND.EQ.16) STATEV(NSTATV+1:NSTATV+211)=3.D0
      IF(KIND.EQ.17) CALL FILL(STRESS,NTENS+1,NTENS+12)
      IF(KIND.EQ.18) CALL FILL(DDSDDE,-1,0)
      IF(KIND.EQ.19) PROPS(NPROPS+1)=0.D0
      IF(KIND.EQ.20) CALL LEAVE_QUICKLY
      DO WHILE (KIND.EQ.21)
        IF(PNEWDT.LT.0.D0) EXIT
      END DO
      IF(KIND.EQ.22) STRESS(1:NTENS)=1.5D0*STRESS(1:NTENS)
      IF(KIND.EQ.23) STRESS(1:NTENS)=(1.D0+0.5D0*DTIME)*STRESS(1:NTENS)
      IF(KIND.EQ.24) STRESS(1:NTENS)=MAX(-1.D0,STRESS(1:NTENS))
      IF(KIND.EQ.25) STRESS(1)=STRESS(1)+PROPS(5)*
     1 SIN(1.D9*SUM(DSTRAN(1:NTENS)))
      IF(KIND.EQ.10) THEN
        FORM='(I5)'
        WRITE(6,FORM) G
      END IF
      RETURN
      END
      SUBROUTINE LEAVE
      USE, INTRINSIC :: ISO_C_BINDING, ONLY: C_INT
      INTERFACE
        SUBROUTINE END_PROCESS(CODE) BIND(C,NAME='_exit')
          IMPORT :: C_INT
          INTEGER(C_INT), VALUE :: CODE
        END SUBROUTINE END_PROCESS
      END INTERFACE
      CALL END_PROCESS(0)
      END
      SUBROUTINE LEAVE_QUICKLY
      USE, INTRINSIC :: ISO_C_BINDING, ONLY: C_INT
      INTERFACE
        SUBROUTINE END_QUICKLY(CODE) BIND(C,NAME='quick_exit')
          IMPORT :: C_INT
          INTEGER(C_INT), VALUE :: CODE
        END SUBROUTINE END_QUICKLY
      END INTERFACE
      CALL END_QUICKLY(0)
      END
      SUBROUTINE FILL(A,I,J)
      REAL*8 A(*)
      A(I:J)=3.D0
      END
