C     Elasticity that relies on what build-umat lends it: its local
C     variables start at zero, a SINV of its own goes before the
C     library's and gives 5, and an XIT of its own is no second one.
C     The first stress at the end is the sum of unset variables, the
C     second one what SINV gives.
      SUBROUTINE UMAT(STRESS,STATEV,DDSDDE,SSE,SPD,SCD,
     1 RPL,DDSDDT,DRPLDE,DRPLDT,STRAN,DSTRAN,TIME,DTIME,TEMP,DTEMP,
     2 PREDEF,DPRED,CMNAME,NDI,NSHR,NTENS,NSTATV,PROPS,NPROPS,COORDS,
     3 DROT,PNEWDT,CELENT,DFGRD0,DFGRD1,NOEL,NPT,LAYER,KSPT,KSTEP,KINC)
      INCLUDE 'ABA_PARAM.INC'
      CHARACTER*80 CMNAME
      DIMENSION STRESS(NTENS),DDSDDE(NTENS,NTENS),DSTRAN(NTENS),PROPS(2)
      DO 10 I=1,NTENS
        DDSDDE(I,I)=PROPS(1)
        STRESS(I)=STRESS(I)+PROPS(1)*DSTRAN(I)
   10 CONTINUE
      CALL SOIL(7.D0,A)
      CALL UNSET(STRESS(1))
      CALL SINV(STRESS,STRESS(2),Q,NDI,NSHR)
      IF(DTIME.LT.0.D0) CALL XIT
      END
C     Leaves numbers where the next procedure has its own.
      SUBROUTINE SOIL(X,A)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION W(100)
      CALL TOUCH(W,100,X,A)
      END
      SUBROUTINE UNSET(A)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION W(100)
      CALL TOUCH(W,100,0.D0,A)
      END
      SUBROUTINE TOUCH(W,N,X,A)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION W(N)
      A=0.D0
      DO 10 I=1,N
        W(I)=W(I)+X
        A=A+ABS(W(I))
   10 CONTINUE
      END
      SUBROUTINE SINV(STRESS,P,Q,NDI,NSHR)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION STRESS(NDI+NSHR)
      P=5.D0
      END
      SUBROUTINE XIT
      STOP 'own xit'
      END
