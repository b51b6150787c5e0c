C     Two models behind PLAXIS's door. 1: isotropic elasticity, PROPS
C     Young's modulus and Poisson's ratio. 2: the same with the limit of
C     Drucker and Prager, q <= PROPS(4) - PROPS(3) p, p = mean stress,
C     returned radially at constant p, from a trial stress by the D that
C     the host hands in, as PLAXIS's own examples do. One state variable
C     counts plastic strain, from the value that task 1 sets.
C     Model 1 writes PROPS(50) in task 1 and refuses to go on without.
      SUBROUTINE USER_MOD(IDTASK,IMOD,ISUNDR,ISTEP,ITER,IEL,INT,X,Y,Z,
     1 TIME0,DTIME,PROPS,SIG0,SWP0,STVAR0,DEPS,D,BULKW,SIG,SWP,STVAR,
     2 IPL,NSTAT,NONSYM,ISTRSDEP,ITIMEDEP,ITANG,IPRJDIR,IPRJLEN,IABORT)
      IMPLICIT REAL*8 (A-H,O-Z)
      DIMENSION PROPS(*),SIG0(*),STVAR0(*),DEPS(*),D(6,6),SIG(*),
     1 STVAR(*),IPRJDIR(*)
      IF(IDTASK.EQ.1) THEN
        IF(STVAR0(1).EQ.0.D0) STVAR0(1)=0.125D0
        PROPS(50)=PROPS(1)/(2.D0*(1.D0+PROPS(2)))
      ELSE IF(IDTASK.EQ.2) THEN
        IF(D(1,1).LE.0.D0) IABORT=1
        DO 10 I=1,6
          SIG(I)=SIG0(I)
          DO 10 J=1,6
            SIG(I)=SIG(I)+D(I,J)*DEPS(J)
   10   CONTINUE
        SWP=SWP0
        IF(ISUNDR.EQ.1) SWP=SWP0+BULKW*(DEPS(1)+DEPS(2)+DEPS(3))
        STVAR(1)=STVAR0(1)
        IPL=0
        IF(IMOD.EQ.2) THEN
          P=(SIG(1)+SIG(2)+SIG(3))/3.D0
          Q=SQRT(0.5D0*((SIG(1)-SIG(2))**2+(SIG(2)-SIG(3))**2
     1     +(SIG(3)-SIG(1))**2)+3.D0*(SIG(4)**2+SIG(5)**2+SIG(6)**2))
          QMAX=MAX(0.D0,PROPS(4)-PROPS(3)*P)
          IF(Q.GT.QMAX) THEN
            IPL=1
            F=QMAX/Q
            STVAR(1)=STVAR(1)+(Q-QMAX)/(3.D0*PROPS(50))
            DO 20 I=1,6
              SIG(I)=F*SIG(I)
              IF(I.LE.3) SIG(I)=SIG(I)+(1.D0-F)*P
   20       CONTINUE
          END IF
        END IF
      ELSE IF(IDTASK.EQ.3.OR.IDTASK.EQ.6) THEN
        G=PROPS(50)
        A=2.D0*G*PROPS(2)/(1.D0-2.D0*PROPS(2))
        DO 30 J=1,6
          DO 30 I=1,6
            D(I,J)=0.D0
            IF(I.LE.3.AND.J.LE.3) D(I,J)=A
            IF(I.EQ.J) D(I,J)=D(I,J)+G
            IF(I.EQ.J.AND.I.LE.3) D(I,J)=D(I,J)+G
   30   CONTINUE
        BULKW=MAX(BULKW,0.D0)
      ELSE IF(IDTASK.EQ.4) THEN
        NSTAT=1
      ELSE IF(IDTASK.EQ.5) THEN
        NONSYM=0
        ISTRSDEP=0
        ITIMEDEP=0
        ITANG=0
      END IF
      RETURN
      END
