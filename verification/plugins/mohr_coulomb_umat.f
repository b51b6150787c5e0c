C     Mohr-Coulomb, perfectly plastic: PROPS are Young's modulus,
C     Poisson's ratio, cohesion, friction and dilatancy angle in degrees.
C     Implicit return in principal stresses s1 >= s2 >= s3 to the plane
C       f = s1 - s3 + (s1 + s3) sin(phi) - 2 c cos(phi) = 0,
C     one of the two edges s1 = s2 or s2 = s3, or the apex, each of which
C     is a linear system (de Souza Neto, Peric, Owen: Computational
C     Methods for Plasticity, 2008, chapter 8). DDSDDE is the derivative.
C     Written as models of the eighties are.
      SUBROUTINE UMAT(STRESS,STATEV,DDSDDE,SSE,SPD,SCD,
     1 RPL,DDSDDT,DRPLDE,DRPLDT,STRAN,DSTRAN,TIME,DTIME,TEMP,DTEMP,
     2 PREDEF,DPRED,CMNAME,NDI,NSHR,NTENS,NSTATV,PROPS,NPROPS,COORDS,
     3 DROT,PNEWDT,CELENT,DFGRD0,DFGRD1,NOEL,NPT,LAYER,KSPT,KSTEP,KINC)
      INCLUDE 'ABA_PARAM.INC'
      CHARACTER*80 CMNAME
      DIMENSION STRESS(NTENS),STATEV(*),DDSDDE(NTENS,NTENS),
     1 DSTRAN(NTENS),PROPS(NPROPS),TIME(2),DROT(3,3)
      DIMENSION S(6),D(6,6),PS(3),AN(3,3),PE(3),DP(3,3),Q(3)
      COMMON /MCWORK/ SINF,SINP,CC,A,G
      PI=4.D0*ATAN(1.D0)
      SINF=SIN(PROPS(4)*PI/180.D0)
      SINP=SIN(PROPS(5)*PI/180.D0)
      CC=2.D0*PROPS(3)*COS(PROPS(4)*PI/180.D0)
      G=PROPS(1)/(2.D0*(1.D0+PROPS(2)))
      A=2.D0*G*PROPS(2)/(1.D0-2.D0*PROPS(2))
C     Trial stress
      DO 10 I=1,6
        S(I)=0.D0
        DO 10 J=1,6
          D(I,J)=0.D0
          IF(I.LE.3.AND.J.LE.3) D(I,J)=A
          IF(I.EQ.J) D(I,J)=D(I,J)+G
          IF(I.EQ.J.AND.I.LE.3) D(I,J)=D(I,J)+G
   10 CONTINUE
      DO 20 I=1,NTENS
        S(I)=STRESS(I)
        DO 20 J=1,NTENS
          S(I)=S(I)+D(I,J)*DSTRAN(J)
   20 CONTINUE
      CALL SPRIND(S,PS,AN,1,3,3)
C     SPRIND promises no order
      DO 30 K=1,2
        DO 30 L=1,2
          IF(PS(L).GE.PS(L+1)) GOTO 30
          T=PS(L)
          PS(L)=PS(L+1)
          PS(L+1)=T
          DO 25 I=1,3
            T=AN(L,I)
            AN(L,I)=AN(L+1,I)
            AN(L+1,I)=T
   25     CONTINUE
   30 CONTINUE
      F=PS(1)-PS(3)+(PS(1)+PS(3))*SINF-CC
      IF(F.GT.0.D0) THEN
        CALL MCRET(PS,PE,DP)
C       Shear of a principal pair: ratio of the gaps
        Q(1)=QUOT(PS(1),PS(2),PE(1),PE(2),DP(1,1)-DP(1,2))
        Q(2)=QUOT(PS(1),PS(3),PE(1),PE(3),DP(1,1)-DP(1,3))
        Q(3)=QUOT(PS(2),PS(3),PE(2),PE(3),DP(2,2)-DP(2,3))
        CALL MCTURN(AN,PE,DP,Q,S,D)
      END IF
      DO 40 I=1,NTENS
        STRESS(I)=S(I)
        DO 40 J=1,NTENS
          DDSDDE(I,J)=D(I,J)
   40 CONTINUE
      RETURN
      END
C
C     Ratio of the gaps, its limit where the trial gap closes
      DOUBLE PRECISION FUNCTION QUOT(P1,P2,E1,E2,SLOPE)
      IMPLICIT REAL*8(A-H,O-Z)
      QUOT=SLOPE
      IF(ABS(P1-P2).GT.1.D-9*(ABS(P1)+ABS(P2))) QUOT=(E1-E2)/(P1-P2)
      RETURN
      END
C
C     Return of principal stresses PS to PE with derivative DP
      SUBROUTINE MCRET(PS,PE,DP)
      IMPLICIT REAL*8(A-H,O-Z)
      COMMON /MCWORK/ SINF,SINP,CC,A,G
      DIMENSION PS(3),PE(3),DP(3,3),AF(3,2),AP(3,2),C(3,3)
      DO 10 I=1,3
        DO 10 J=1,3
          C(I,J)=A
          IF(I.EQ.J) C(I,J)=A+2.D0*G
   10 CONTINUE
C     The plane; then the edge that its stress has crossed; then the apex
      CALL MCPLAN(1,3,SINF,AF(1,1))
      CALL MCPLAN(1,3,SINP,AP(1,1))
      CALL MCSOLV(1,PS,AF,AP,C,PE,DP)
      TOL=1.D-12*(ABS(PS(1))+ABS(PS(3))+CC)
      IF(PE(1).GE.PE(2)-TOL.AND.PE(2).GE.PE(3)-TOL) RETURN
      IF(PE(1).LT.PE(2)) THEN
        CALL MCPLAN(2,3,SINF,AF(1,2))
        CALL MCPLAN(2,3,SINP,AP(1,2))
      ELSE
        CALL MCPLAN(1,2,SINF,AF(1,2))
        CALL MCPLAN(1,2,SINP,AP(1,2))
      END IF
      CALL MCSOLV(2,PS,AF,AP,C,PE,DP)
      APEX=CC/(2.D0*MAX(SINF,1.D-12))
      IF((PE(1)+PE(2)+PE(3))/3.D0.LE.APEX) RETURN
      DO 30 I=1,3
        PE(I)=APEX
        DO 30 J=1,3
          DP(I,J)=0.D0
   30 CONTINUE
      RETURN
      END
C
C     Normal of the plane of s(I) as largest and s(K) as smallest stress
      SUBROUTINE MCPLAN(I,K,SI,AN)
      IMPLICIT REAL*8(A-H,O-Z)
      DIMENSION AN(3)
      AN(1)=0.D0
      AN(2)=0.D0
      AN(3)=0.D0
      AN(I)=1.D0+SI
      AN(K)=-1.D0+SI
      RETURN
      END
C
C     Return to N planes: PE = PS - C AP x with AF' PE = CC
      SUBROUTINE MCSOLV(N,PS,AF,AP,C,PE,DP)
      IMPLICIT REAL*8(A-H,O-Z)
      COMMON /MCWORK/ SINF,SINP,CC,A,G
      DIMENSION PS(3),AF(3,2),AP(3,2),C(3,3),PE(3),DP(3,3)
      DIMENSION B(3,2),H(2,2),HI(2,2),F(2),X(2)
      DO 30 K=1,N
        F(K)=-CC
        DO 20 I=1,3
          F(K)=F(K)+AF(I,K)*PS(I)
          B(I,K)=0.D0
          DO 10 J=1,3
            B(I,K)=B(I,K)+C(I,J)*AP(J,K)
   10     CONTINUE
   20   CONTINUE
   30 CONTINUE
      DO 40 K=1,N
        DO 40 L=1,N
          H(K,L)=0.D0
          DO 40 I=1,3
            H(K,L)=H(K,L)+AF(I,K)*B(I,L)
   40 CONTINUE
      IF(N.EQ.1) THEN
        HI(1,1)=1.D0/H(1,1)
      ELSE
        DET=H(1,1)*H(2,2)-H(1,2)*H(2,1)
        HI(1,1)=H(2,2)/DET
        HI(2,2)=H(1,1)/DET
        HI(1,2)=-H(1,2)/DET
        HI(2,1)=-H(2,1)/DET
      END IF
      DO 50 K=1,N
        X(K)=0.D0
        DO 50 L=1,N
          X(K)=X(K)+HI(K,L)*F(L)
   50 CONTINUE
      DO 70 I=1,3
        PE(I)=PS(I)
        DO 60 K=1,N
          PE(I)=PE(I)-B(I,K)*X(K)
   60   CONTINUE
        DO 70 J=1,3
          DP(I,J)=0.D0
          IF(I.EQ.J) DP(I,J)=1.D0
          DO 70 K=1,N
            DO 70 L=1,N
              DP(I,J)=DP(I,J)-B(I,K)*HI(K,L)*AF(J,L)
   70 CONTINUE
      RETURN
      END
C
C     Stress S of principal values PE along the rows of AN, and
C     D = (DP on the normal, Q on the shear components) times elastic D
      SUBROUTINE MCTURN(AN,PE,DP,Q,S,D)
      IMPLICIT REAL*8(A-H,O-Z)
      DIMENSION AN(3,3),PE(3),DP(3,3),Q(3),S(6),D(6,6)
      DIMENSION V(6,6),W(6,6),T(6,6),IR(6),IC(6)
      DATA IR/1,2,3,1,1,2/,IC/1,2,3,2,3,3/
C     V: a tensor, components 11..23, in the principal frame
      DO 10 I=1,6
        DO 10 J=1,6
          V(I,J)=AN(IR(I),IR(J))*AN(IC(I),IC(J))
          IF(J.GT.3) V(I,J)=V(I,J)+AN(IR(I),IC(J))*AN(IC(I),IR(J))
   10 CONTINUE
C     W: and back
      DO 20 I=1,6
        DO 20 J=1,6
          W(I,J)=AN(IR(J),IR(I))*AN(IC(J),IC(I))
          IF(J.GT.3) W(I,J)=W(I,J)+AN(IC(J),IR(I))*AN(IR(J),IC(I))
   20 CONTINUE
      DO 30 I=1,6
        S(I)=W(I,1)*PE(1)+W(I,2)*PE(2)+W(I,3)*PE(3)
   30 CONTINUE
C     T = map in the principal frame times V, times elastic D
      DO 50 I=1,6
        DO 50 J=1,6
          T(I,J)=0.D0
          IF(I.GT.3) T(I,J)=Q(I-3)*V(I,J)
          IF(I.GT.3) GOTO 50
          DO 40 K=1,3
            T(I,J)=T(I,J)+DP(I,K)*V(K,J)
   40     CONTINUE
   50 CONTINUE
      DO 60 I=1,6
        DO 60 J=1,6
          V(I,J)=0.D0
          DO 60 K=1,6
            V(I,J)=V(I,J)+T(I,K)*D(K,J)
   60 CONTINUE
      DO 70 I=1,6
        DO 70 J=1,6
          D(I,J)=0.D0
          DO 70 K=1,6
            D(I,J)=D(I,J)+W(I,K)*V(K,J)
   70 CONTINUE
      RETURN
      END
